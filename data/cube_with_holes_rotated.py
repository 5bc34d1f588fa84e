# The cube with two crossing holes, turned so that nothing is parallel to the grid.

side = 2
radius = 0.4

units("mm")

body = box(size=(side, side, side)).name("body")
bore_x = cylinder(radius, axis="x").name("bore_x")
bore_z = cylinder(radius, axis="z").name("bore_z")

turned = (body - bore_x - bore_z).rotate(179.85594446358624, axis=(0.30529502354055693, -0.2801478599619021, -0.9101165448227702))
part(turned)

group("bores", faces("bore_*"))
