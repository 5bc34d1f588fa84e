# A part of formulas alone: a rounded body from a single inequality, a waist from another, cut flat at the bottom.

k = 4          # 2 is an ellipsoid, large values approach a box
waist = 0.25

rounded = solid((x / 1.2) ** k + (y / 0.8) ** k + (z / 0.9) ** k <= 1).name("skin")
groove = solid(hypot(hypot(x, y) - 1.1, z) <= waist).name("groove")
ground = solid(z >= -0.6).name("ground")

part(rounded & ground - groove)
