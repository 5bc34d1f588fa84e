# Faces far narrower than the least length that is asked for: no short edges belong there, and no nodes inside them.
bevel = 0.03
a = 10
corners = [(-a, -a), (a - bevel, -a), (a, bevel - a), (a, a - bevel), (a - bevel, a), (-a, a)]
part(extrude_edges(polyline(corners, closed=True), "z", 8).name("block"))
mesh(size=2, size_min=0.5)
