# A wide face with a region that runs out narrow between two edges, on both ends of the solid.
gap = 0.08
wedge = [(0, 0), (20, 0), (20, 10), (14, 10), (8, gap), (2, 1.4 * gap), (0, gap)]
part(extrude_edges(polyline(wedge, closed=True), "z", 5).name("wedge"))
mesh(size=1.2)
