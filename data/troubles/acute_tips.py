# Tips of surfaces of revolution that bend the more the nearer to the pole, up to any curvature at the pole itself.
spindle = revolve_edges(spline([(0, 0, 0), (3, 0, 1), (2, 0, 6), (0, 0, 9)]), "z").name("spindle")
rim = spline([(8, 0, 0), (5, 0, 4), (1.5, 0, 5), (0, 0, 9)], start=(0, 0, 1), end=(-0.15, 0, 1))
horn = revolve_edges(chain([rim, polyline([(0, 0, 0), (8, 0, 0)])]), "z").move((20, 0, 0)).name("horn")
part([spindle, horn])
mesh(size=1)
