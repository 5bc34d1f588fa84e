# A graded lattice in a flange: the sheet grows thicker toward the rim, which no swept or patterned model does.

radius = 1.0
height = 0.8
period = 1.0
thin = 0.2
thick = 0.35

units("mm")

r = hypot(x, y)
wall = thin + (thick - thin) * r ** 2 / radius ** 2
k = 2 * pi / period
g = (sin(k * x) * cos(k * y) + sin(k * y) * cos(k * z) + sin(k * z) * cos(k * x)) / k

core = cylinder(radius - 0.05, height=height - 0.1).name("core")
sheet = solid(g <= wall / 2).name("outer") & solid(g >= -wall / 2).name("inner")
rim = (cylinder(radius, height=height) - cylinder(radius - 0.1)).name("rim")
plates = (cylinder(radius - 0.05, at=(0, 0, height / 2 - 0.05), height=0.1)
          | cylinder(radius - 0.05, at=(0, 0, 0.05 - height / 2), height=0.1)).name("plate")

part((core & sheet) | rim | plates)
