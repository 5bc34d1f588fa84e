"""Every public name is described; arrays with their shape, lengths and angles with their unit; and what the package's page shows runs."""

import ast
import inspect
import re
from pathlib import Path

import numpy as np
import pytest

import rvachev as rv

STUBS = ast.parse(Path(rv._rvachev.__file__).with_name("_rvachev.pyi").read_text(encoding="utf-8"))
PAGE = Path(__file__).parents[1] / "README.md"
SHAPE = re.compile(r"\([a-z]\w*,( ?\w+)?(, ?\w+)*\)", re.IGNORECASE)
UNIT = re.compile(r"\bunits?\b|degrees|radians")
# Arguments of the compiled functions that are lengths or angles.
LENGTHS = {"radius", "size", "h", "by", "along", "within", "spacing"}
ANGLES = {"degrees", "off"}
# What is for pickle and for the modules of the package only.
INTERNAL = {"mesh_again", "part_again", "task_again", "piece_again", "made"}


def members():
    """Public functions, classes, methods and properties, by name."""
    for name in [*rv.__all__, "min", "max", "hypot", "clamp"]:
        found = getattr(rv, name)
        if isinstance(found, rv.Expr):
            continue
        yield name, found
        if inspect.isclass(found) and not issubclass(found, BaseException):
            yield from ((f"{name}.{n}", inspect.getattr_static(found, n)) for n in vars(found) if not n.startswith("_"))


def described(value):
    doc = value.__func__.__doc__ if isinstance(value, staticmethod) else value.__doc__
    return inspect.cleandoc(doc or "")


def annotated():
    """What stubs say of arguments and results, by name."""
    for node in STUBS.body:
        for member in node.body if isinstance(node, ast.ClassDef) else [node]:
            if isinstance(member, ast.FunctionDef):
                prefix = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
                kinds = [a.annotation for a in [*member.args.args, *member.args.kwonlyargs]] + [member.returns]
                yield prefix + member.name, " ".join(ast.unparse(k) for k in kinds if k)


def documented(name):
    owner, _, member = name.rpartition(".")
    if not owner:
        return described(getattr(rv, member))
    # Edges and Built have the methods of a class that only the stubs have.
    return described(inspect.getattr_static(rv.Edges if owner == "_Placed" else getattr(rv, owner), member))


def test_every_public_name_is_described():
    wanting = [name for name, value in members() if len(described(value).split()) < 2]
    assert wanting == []
    assert "unit" in rv.__doc__ and "degrees" in rv.__doc__


def test_what_gives_or_takes_arrays_tells_shapes_and_units():
    arrays = {n: kinds for n, kinds in annotated() if ("NDArray" in kinds or "ArrayLike" in kinds) and n not in INTERNAL}
    arrays = {n: kinds for n, kinds in arrays.items() if not n.rpartition(".")[2].startswith("_")}
    assert len(arrays) > 30
    assert [n for n in arrays if not SHAPE.search(documented(n))] == []
    floats = [n for n, kinds in arrays.items() if "float64" in kinds or "ArrayLike" in kinds]
    # A class of a point is a number without one.
    assert [n for n in floats if n != "node_classes" and not UNIT.search(documented(n))] == []


def test_shapes_and_units_are_looked_for_where_they_are():
    assert all(SHAPE.search(s) for s in ("(n, 3)", "(m,)", "float64 (n, ...) or (k, 3)", "(height, width, 4)"))
    assert not any(SHAPE.search(s) for s in ("points", "(0, 0, 0)", "(degrees)", "f(x)"))


def test_lengths_and_angles_of_arguments_have_units():
    wanting = []
    for name, value in members():
        if inspect.isclass(value) or not callable(value) or inspect.isfunction(value):
            continue
        arguments = set(inspect.signature(value).parameters) - {"self"}
        text = described(value)
        if arguments & LENGTHS and not UNIT.search(text) or arguments & ANGLES and "degrees" not in text:
            wanting.append(name)
    assert wanting == []


def test_the_page_of_the_package_runs(tmp_path, monkeypatch, capsys):
    text = PAGE.read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert blocks and 10 <= len(text.splitlines()) <= 30
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    volume, clamped, shortfalls = capsys.readouterr().out.split(maxsplit=2)
    # A cube of edge 2 with a bore of radius 0.5.
    assert float(volume) == pytest.approx(8 - np.pi / 2, rel=5e-3)
    assert int(clamped) > 0 and shortfalls.strip() == "[]"
    assert (tmp_path / "bored.msh").exists() and (tmp_path / "bored.stl").exists()
    # Every call the text names is there.
    for call in re.findall(r"`(\w+)\(", text):
        assert hasattr(rv, call), call
    root = PAGE.parents[1]
    for path in re.findall(r"`((?:docs|examples)/[\w./]+)`", text):
        assert (root / path).exists(), path
