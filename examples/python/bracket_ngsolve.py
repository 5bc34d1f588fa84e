"""The bracket in NGSolve: tetrahedra with boundary conditions by name, of any order. `pip install ngsolve gmsh`, then run it."""

import ngsolve as ng
import numpy as np
from bracket_model import bracket, tell


def displacements(model, order=1):
    """float64 (n, 3): at the points of the mesh, whatever the order. `clamped` does not move, the force is spread over `loaded`."""
    mesh = ng.Mesh(model.filled.to_netgen())
    space = ng.VectorH1(mesh, order=order, dirichlet="clamped")
    u, v = space.TnT()
    young, poisson = model.young, model.poisson
    shear, bulk = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))

    def strain(w):
        return (ng.Grad(w) + ng.Grad(w).trans) / 2

    stiffness = ng.BilinearForm(space, symmetric=True)
    stiffness += (2 * shear * ng.InnerProduct(strain(u), strain(v)) + bulk * ng.div(u) * ng.div(v)) * ng.dx
    area = ng.Integrate(1, mesh, definedon=mesh.Boundaries("loaded"))
    pull = ng.CoefficientFunction(tuple(model.forces.sum(axis=0) / area))
    load = ng.LinearForm(pull * v * ng.ds("loaded"))
    found = ng.GridFunction(space)
    found.vec.data = stiffness.Assemble().mat.Inverse(space.FreeDofs(), "sparsecholesky") * load.Assemble().vec
    # Values at points come first, in each component.
    return np.array([part.vec.FV().NumPy()[: mesh.nv] for part in found.components]).T


if __name__ == "__main__":
    the_bracket = bracket()
    tell("NGSolve", the_bracket, displacements(the_bracket))
    worst = np.linalg.norm(displacements(the_bracket, order=2), axis=1).max()
    print(f"  with elements of order 2 it moves {worst:.6e} mm")
