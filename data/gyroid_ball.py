# A ball cut out of a gyroid's sheet: its faces run together at any angle, down to a few degrees.
units("mm")
part(gyroid(period=2, thickness=0.4) & sphere(2.3))
