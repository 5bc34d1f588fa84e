# A cube with a spherical bite out of one corner.

side = 2
radius = 0.8

body = box(size=(side, side, side)).name("body")
bite = sphere(radius, at=(side / 2, side / 2, side / 2)).name("bite")

part(body - bite)
