# A sheet of gyroid in a box: the classic of additive manufacturing.

side = 2
period = 2
thickness = 0.3

units("mm")

block = box(size=(side, side, side)).name("block")
sheet = gyroid(period, thickness).name("sheet")

part(block & sheet)
