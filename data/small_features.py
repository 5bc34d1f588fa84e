# What is smaller than the cells of a mesh of size 0.1: a slit, a bore, a wire, a pin, a bump and a dent.

units("mm")

block = box(size=(2, 2, 2)).name("block")
slit = box(size=(4, 4, 0.03), at=(0, 0, 0.325)).name("slit")
bore = cylinder(0.01, at=(-0.2, -0.3, 0)).name("bore")
dent = sphere(0.06, at=(0.5, -0.4, 1)).name("dent")
bump = sphere(0.05, at=(0.3, 0.2, 1.02)).name("bump")
pin = box(size=(0.03, 0.03, 0.5), at=(-0.5, 0.5, 1.25)).name("pin")
wire = cylinder(0.01, at=(0.7, -0.7, 0.5), height=2.4).name("wire")

part(block - slit - bore - dent | bump | pin | wire)
