# Faces narrower than the least edge: no node belongs inside them.
bevel = 0.12
a = 10
corners = [(-a, -a), (a - bevel, -a), (a, bevel - a), (a, a - bevel), (a - bevel, a), (-a, a)]
part(extrude_edges(polyline(corners, closed=True), "z", 8).name("block"))
mesh(size=2)
