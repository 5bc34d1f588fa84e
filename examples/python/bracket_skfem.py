"""The bracket in scikit-fem: linear elasticity on 4-node tetrahedra. `pip install scikit-fem gmsh`, then run it."""

import numpy as np
import skfem
from bracket_model import bracket, tell
from skfem.models.elasticity import lame_parameters, linear_elasticity


def displacements(model):
    """float64 (n, 3)."""
    mesh = skfem.MeshTet(np.ascontiguousarray(model.points.T), np.ascontiguousarray(model.tets.T), sort_t=True)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP1()))
    stiffness = linear_elasticity(*lame_parameters(model.young, model.poisson)).assemble(basis)
    force = np.zeros(basis.N)
    force[basis.nodal_dofs] = model.forces.T
    held = basis.nodal_dofs[:, model.clamped].ravel()
    return skfem.solve(*skfem.condense(stiffness, force, D=held))[basis.nodal_dofs].T


if __name__ == "__main__":
    the_bracket = bracket()
    tell("scikit-fem", the_bracket, displacements(the_bracket))
