# A wing whose profile is one curve that ends where it starts: its two sides run together at a sharp trailing edge, and the
# nearest point of the surface may be on the wrong one.
outline = [(1, 0), (0.75, 0.045), (0.5, 0.075), (0.25, 0.08), (0.08, 0.055), (0, 0), (0.08, -0.03), (0.25, -0.05), (0.5, -0.045), (0.75, -0.03), (1, 0)]


def foil(c):
    return spline([(s * c, 0, z * c) for s, z in outline])


part(loft([foil(4), foil(2.5).move((1.2, 8, 0.3))]).name("wing"))
mesh(size="2%")
