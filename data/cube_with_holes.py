# The field's sample: a cube with two crossing through-holes of equal radius.
# At (0, +-radius, 0) the two cylinders touch; four creases meet there and flatten out.

side = 2
radius = 0.4

units("mm")

body = box(size=(side, side, side)).name("body")
bore_x = cylinder(radius, axis="x").name("bore_x")
bore_z = cylinder(radius, axis="z").name("bore_z")

part(body - bore_x - bore_z)

group("clamped", faces("body.xmin"))
group("loaded", faces("body.xmax"))
group("bores", faces("bore_*"))
