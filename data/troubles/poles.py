# A surface of revolution with a pole at both ends, a sphere and a cone: the poles are edges of the parameter domain.
spindle = revolve_edges(spline([(0, 0, 0), (3, 0, 1), (2, 0, 6), (0, 0, 9)]), "z").name("spindle")
ball = revolve_edges(arc((0, 0, -3), (3, 0, 0), (0, 0, 3)), "z").move((8, 0, 3)).name("ball")
tip = revolve_edges(polyline([(0, 0, 0), (3, 0, 0), (0, 0, 6)]), "z").move((16, 0, 0)).name("tip")
part([spindle, ball, tip])
mesh(size=0.6)
