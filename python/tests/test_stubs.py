"""The stubs name what the compiled module has, with its arguments, and nothing else."""

import ast
import inspect
from pathlib import Path

import rvachev
from rvachev import _rvachev

STUBS = ast.parse(Path(rvachev.__file__).with_name("_rvachev.pyi").read_text(encoding="utf-8"))
# What is for pickle only.
INTERNAL = {"mesh_again", "part_again"}


def arguments(function):
    a = function.args
    names = [x.arg for x in [*a.posonlyargs, *a.args]]
    names += [f"*{a.vararg.arg}"] if a.vararg else []
    names += [x.arg for x in a.kwonlyargs]
    return names + ([f"**{a.kwarg.arg}"] if a.kwarg else [])


def signature(value):
    marks = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
    return [marks.get(p.kind, "") + p.name for p in inspect.signature(value).parameters.values()]


def public(names):
    return {n for n in names if not n.startswith("_")}


def test_the_module_has_what_its_stubs_say():
    functions = {n.name: n for n in STUBS.body if isinstance(n, ast.FunctionDef)}
    there = {n for n in public(vars(_rvachev)) if callable(getattr(_rvachev, n)) and not inspect.isclass(getattr(_rvachev, n))}
    assert there - INTERNAL == set(functions)
    for name, node in functions.items():
        assert signature(getattr(_rvachev, name)) == arguments(node), name


def test_classes_have_what_their_stubs_say():
    classes = {n.name: n for n in STUBS.body if isinstance(n, ast.ClassDef)}
    for name in public(vars(_rvachev)):
        found = getattr(_rvachev, name)
        if not inspect.isclass(found):
            continue
        parents = [b.id for b in classes[name].bases if isinstance(b, ast.Name) and b.id in classes]
        said = {n.name: n for c in [*parents, name] for n in classes[c].body if isinstance(n, ast.FunctionDef)}
        assert public(vars(found)) == public(said), name
        for method in public(said):
            if not any(isinstance(d, ast.Name) and d.id == "property" or isinstance(d, ast.Attribute) for d in said[method].decorator_list):
                of_stub = [a for a in arguments(said[method]) if a != "self"]
                assert [a for a in signature(getattr(found, method)) if a != "self"] == of_stub, f"{name}.{method}"


def test_types_are_announced():
    assert Path(rvachev.__file__).with_name("py.typed").exists()
