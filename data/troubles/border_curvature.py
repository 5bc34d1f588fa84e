# A surface that bends most at the border of its parameters, where second derivatives are hard to come by.
rim = spline([(8, 0, 0), (5, 0, 4), (1.5, 0, 5), (0, 0, 9)], start=(0, 0, 1), end=(-0.15, 0, 1))
part(revolve_edges(chain([rim, polyline([(0, 0, 0), (8, 0, 0)])]), "z").name("horn"))
mesh(size=1.2)
