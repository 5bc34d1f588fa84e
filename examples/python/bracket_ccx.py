"""The bracket in CalculiX: nodes, elements and sets by name in an .inp file. Needs `ccx` (Debian: calculix-ccx) and `pip install gmsh`."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from bracket_model import bracket, tell


def deck(model):
    """The input file. CalculiX counts from 1, and reads twenty characters of a number."""
    yield "*NODE, NSET=ALL"
    for i, p in enumerate(model.points.tolist(), 1):
        yield f"{i}, " + ", ".join(f"{c:.12e}" for c in p)
    yield "*ELEMENT, TYPE=C3D4, ELSET=BODY"
    for i, t in enumerate((model.tets + 1).tolist(), 1):
        yield f"{i}, " + ", ".join(map(str, t))
    yield "*NSET, NSET=CLAMPED"
    yield from (f"{i}," for i in (model.clamped + 1).tolist())
    yield f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{model.young}, {model.poisson}\n*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL"
    yield "*BOUNDARY\nCLAMPED, 1, 3\n*STEP\n*STATIC\n*CLOAD"
    for i in np.flatnonzero(model.forces.any(axis=1)).tolist():
        yield from (f"{i + 1}, {k}, {f:.12e}" for k, f in enumerate(model.forces[i].tolist(), 1))
    yield "*NODE PRINT, NSET=ALL\nU\n*END STEP"


def displacements(model):
    """float64 (n, 3)."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "bracket.inp").write_text("\n".join(deck(model)) + "\n")
        run = subprocess.run(["ccx", "-i", "bracket"], cwd=folder, capture_output=True, text=True)
        table = Path(folder, "bracket.dat")
        if run.returncode or not table.exists():
            raise RuntimeError(f"ccx failed\n{run.stdout[-3000:]}{run.stderr}")
        rows = [line.split() for line in table.read_text().splitlines()]
    u = np.zeros_like(model.points)
    numbers = [row for row in rows if len(row) == 4 and row[0].isdigit()]
    if len(numbers) != len(u):
        raise RuntimeError(f"ccx wrote {len(numbers)} displacements for {len(u)} points")
    for i, *v in numbers:
        u[int(i) - 1] = [float(c) for c in v]
    return u


if __name__ == "__main__":
    the_bracket = bracket()
    tell("CalculiX", the_bracket, displacements(the_bracket))
