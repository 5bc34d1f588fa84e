# A bore far smaller than the edges of the mesh, its rim of two half circles: divided coarsely both fall together.
bore = 0.4
half = [arc((bore, 0, 0), (0, bore, 0), (-bore, 0, 0)), arc((-bore, 0, 0), (0, -bore, 0), (bore, 0, 0))]
plate = polyline([(-20, -20), (20, -20), (20, 20), (-20, 20)], closed=True)
part(extrude_edges([plate, chain(half)], "z", 6).name("plate"))
mesh(size=5)
