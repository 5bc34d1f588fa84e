# The cube with two holes whose axes lie near its edges: each hole opens an edge along its whole length,
# so that creases end on creases.
side = 2
radius = 0.4
inset = 0.1     # how far the axes lie inside the faces

units("mm")

edge = side / 2 - inset
body = box(size=(side, side, side)).name("body")
bore_x = cylinder(radius, axis="x", at=(0, edge, edge)).name("bore_x")
bore_z = cylinder(radius, axis="z", at=(-edge, -edge, 0)).name("bore_z")

part(body - bore_x - bore_z)
