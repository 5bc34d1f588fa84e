# A face whose two wide regions are joined by a narrow one, at both ends of the solid: nothing but needles fits there.
gap = 0.004
outline = [(0, 0), (20, 0), (20, 4), (12, 4), (12, gap), (8, gap), (8, 8), (0, 8)]
part(extrude_edges(polyline(outline, closed=True), "z", 3).name("plate"))
mesh(size=1.2)
