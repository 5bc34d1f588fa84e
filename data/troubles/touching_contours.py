# A face whose inner contour touches the outer one at a vertex, and nowhere else; the hole draws in below it.
block = polyline([(0, 0), (12, 0), (12, 12), (0, 12)], closed=True)
notch = polyline([(0, 0), (7, 3), (3, 7)], closed=True)
part(extrude_edges([block, notch], "z", 6, hole_scale=0.6).name("block"))
mesh(size=1.2)
