# A wide tip: the profile meets the axis at a slope, and across it the surface bends the more the nearer to the pole, without end.
top = spline([(4, 0, 0), (2.5, 0, 1.2), (0, 0, 1.7)], start=(0, 0, 1), end=(-1, 0, 0.45))
dome = revolve_edges(chain([top, polyline([(0, 0, 0), (4, 0, 0)])]), "z").name("dome")
part(dome)
mesh(size=1)
