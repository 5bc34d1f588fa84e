# A ring and a ball joined by a fillet.

fillet = 0.2

ring = torus(0.8, 0.22)
ball = sphere(0.45, at=(0.8, 0, 0.35))

part(blend(ring, ball, fillet).name("skin"))
