# A bracket of a dozen primitives: base, wall, two bosses, a rib, and eight holes.

units("mm")

base = box(lo=(-1, -0.6, -0.6), hi=(1, 0.6, -0.4)).name("base")
wall = box(lo=(-1, -0.6, -0.6), hi=(-0.8, 0.6, 0.6)).name("wall")
boss_base = cylinder(0.3, axis="z", at=(0.3, 0, -0.335), height=0.33).name("boss_base")
boss_wall = cylinder(0.25, axis="x", at=(-0.75, 0, 0.2), height=0.3).name("boss_wall")

# a triangle in the plane of the rib, turned upright: (x, z) with x + z <= -0.95
rib = extrude(polygon([(-0.9, -0.5), (-0.45, -0.5), (-0.9, -0.05)]), 0.12).rotate(90, axis="x").name("rib")

shaft_base = cylinder(0.15, axis="z", at=(0.3, 0, 0)).name("shaft_base")
shaft_wall = cylinder(0.12, axis="x", at=(0, 0, 0.2)).name("shaft_wall")
base_holes = [cylinder(0.08, axis="z", at=(px, py, 0)).name(f"bolt_base_{i}{j}")
              for i, px in enumerate([0.78, -0.4]) for j, py in enumerate([0.41, -0.41])]
wall_holes = [cylinder(0.07, axis="x", at=(0, py, 0.4)).name(f"bolt_wall_{j}") for j, py in enumerate([0.4, -0.4])]

part((base | wall | boss_base | boss_wall | rib) - union([shaft_base, shaft_wall] + base_holes + wall_holes))

group("bolts", faces("bolt_*"))
group("mounting", faces("base.zmin", "wall.xmin"))
