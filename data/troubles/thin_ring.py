# A ring whose circles differ by little: divided coarsely the outer contour cuts the inner one.
wall = 0.25
part(extrude_edges([circle(20), circle(20 - wall)], "z", 8).name("ring"))
mesh(size=4)
