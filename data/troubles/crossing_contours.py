# A ring whose circles differ by little, where no edge may be short: divided as coarsely as that the outer contour cuts the
# inner one, until both are divided more finely.
wall = 0.25
part(extrude_edges([circle(20), circle(20 - wall)], "z", 8).name("ring"))
mesh(size=8, size_min=8)
