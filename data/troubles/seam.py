# A closed side with a seam: every point of it has two places in the parameter domain.
part(extrude_edges(spline([(6, 0), (1, 5), (-6, 3), (-5, -4), (2, -6)], closed=True), "z", 10).name("tube"))
mesh(size=1)
