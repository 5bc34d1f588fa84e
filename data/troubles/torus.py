# Periodic both ways, without any edge of its own but the seams.
part(revolve_edges(circle(2, at=(6, 0, 0), axis="y"), "z").name("ring"))
mesh(size=0.8)
