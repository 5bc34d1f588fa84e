# A block in a wind tunnel, bored through along the wind.
units("m")
block = box(size=(1, 1, 1)).name("block")
bore = cylinder(0.3, axis="x").name("bore")
part(block - bore)
mesh(size=0.08)
