"""rvachev beside gmsh and beside fidget with pymeshlab: the same parts, the same number of triangles, one run.

    python3 benches/peers/run.py [PART...] [--cells 32,64,128] [--reps 3]
    python3 benches/peers/run.py --picture benches/peers/won.png

PART is one of cube_with_holes, cube_with_holes_rotated, bracket, gyroid_block, many_solids; without, all of them. Prints
one Markdown table per part. Needs Unix, Python 3.10 or newer with `venv`, and cargo; installs the peers from the pinned
`requirements.txt` below `target/peers-env`, from PyPI, and builds fidget by `benches/fidget`.

Every program gets one thread. Times are CPU seconds, user and system, the least of the repetitions, one where a peer takes
longer than 5 s:

    rvachev           the whole process: start, reading the part file, meshing, certificate, writing
    gmsh              the exact B-rep built in its Open CASCADE kernel + the meshing of its surfaces
    fidget+pymeshlab  fidget's octree and dual contouring + isotropic remeshing, 10 iterations, features at 30 degrees

All meshes are measured by `rvachev check --against PART`; what that says is compared with libigl and pymeshlab in the tests.
"""
import argparse
import hashlib
import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGET = ROOT / "target"
OUT = TARGET / "peers"
OURS = TARGET / "release" / "rvachev"
FIDGET = ROOT / "benches" / "fidget" / "target" / "release" / "fidget-bench"

# Half the side of the cube that N cells divide, as in `benches/fidget`; what fidget's driver calls the part; what gmsh can.
PARTS = {
    "cube_with_holes": (1.237, "cube with holes", True),
    "cube_with_holes_rotated": (1.75, "rotated cube", True),
    "bracket": (1.237, "bracket", True),
    "gyroid_block": (1.237, "gyroid block", False),
    "many_solids": (1.237, None, False),
}
MANY_CELLS = 256

COLUMNS = ["N", "program", "triangles", "CPU s", "ktri/s", "smallest angle", "5th percentile", "mean 2r/R",
           "recall / precision", "corners", "Euler", "self-int.", "rms/h", "eps_n", "our time / its"]


def fail(why):
    sys.exit(f"run.py: {why}")


def say(what):
    print(f"# {what}", file=sys.stderr, flush=True)


def call(command, environment=None, good=(0,)):
    """Runs to the end; (CPU seconds, exit code, standard output)."""
    command = [str(c) for c in command]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
    except OSError as e:
        fail(f"cannot run {command[0]}: {e}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in good:
        fail(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, done.returncode, done.stdout


# ------------------------------------------------------------------------------------------------------ preparation

class Peers:
    """The Python with the peers in it."""

    def __init__(self):
        wanted = HERE / "requirements.txt"
        key = hashlib.sha256(wanted.read_bytes() + sys.version.encode()).hexdigest()[:16]
        folder = TARGET / "peers-env" / f"bench-{key}"
        self.python = folder / "bin" / "python"
        self.environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
        self.environment |= {"PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        if not (folder / "ready").exists():
            say(f"installing the peers below {folder}")
            shutil.rmtree(folder, ignore_errors=True)
            call([sys.executable, "-m", "venv", folder])
            call([self.python, "-m", "pip", "install", "--quiet", "-r", wanted], self.environment)
            (folder / "ready").touch()
        self.lend_opengl(folder / "lib-gl")

    def lend_opengl(self, folder):
        """pymeshlab is linked against OpenGL and does not call it here: where there is none, an empty library serves."""
        probe = [self.python, "-c", "import sys, os; sys.setdlopenflags(os.RTLD_LAZY); import gmsh, pymeshlab"]
        first = subprocess.run(probe, env=self.environment, capture_output=True, text=True)
        if first.returncode == 0:
            return
        if "libGL.so.1" in first.stderr:
            folder.mkdir(exist_ok=True)
            call(["cc", "-shared", "-Wl,-soname,libGL.so.1", "-x", "c", "/dev/null", "-o", folder / "libGL.so.1"])
            self.environment["LD_LIBRARY_PATH"] = str(folder)
            first = subprocess.run(probe, env=self.environment, capture_output=True, text=True)
        if first.returncode != 0:
            fail(f"gmsh or pymeshlab does not load (Debian: apt install libgl1 libopengl0 libglu1-mesa)\n{first.stderr}")

    def make(self, *arguments):
        out = call([self.python, HERE / "makers.py", *arguments], self.environment)[2]
        return json.loads(out.splitlines()[-1])


def build():
    if shutil.which("cargo") is None:
        fail("cargo is not on the path (https://rustup.rs)")
    say("building rvachev and the fidget driver")
    call(["cargo", "build", "--release", "--manifest-path", ROOT / "Cargo.toml", "--target-dir", TARGET])
    fidget = ROOT / "benches" / "fidget"
    call(["cargo", "build", "--release", "--manifest-path", fidget / "Cargo.toml", "--target-dir", fidget / "target"])


# --------------------------------------------------------------------------------------------------------- measuring

class Mesh:
    """A mesh, who made it, how long it took by steps, and what `check` says."""

    def __init__(self, program, path, part, seconds, note=""):
        self.program, self.seconds, self.note = program, seconds, note
        out = call([OURS, "check", path, "--against", part_file(part), "--json"], good=(0, 1))[2]
        self.check = json.loads(out)

    @property
    def triangles(self):
        return self.check["triangles"]

    @property
    def total(self):
        return sum(self.seconds)

    def euler(self):
        faults = [word for word in ("closed", "manifold", "oriented") if not self.check[word]]
        return ", ".join([str(self.check["euler"])] + [f"not {f}" for f in faults])

    def cells(self, h):
        c, q = self.check, self.check["quality"]
        f, d = c.get("features"), c.get("deviation")
        return [
            f"{self.triangles:,}".replace(",", " "),
            " + ".join(f"{s:.2f}" for s in self.seconds),
            f"{self.triangles / self.total / 1000:.1f}",
            f"{q['min_angle']:.1f}°",
            f"{q['p05_angle']:.1f}°",
            f"{q['mean_radius_ratio']:.3f}",
            f"{f['recall']:.3f} / {f['precision']:.3f}" if f else "",
            f"{f['corners_found']} of {f['corners_true']}" if f else "",
            self.euler(),
            str(c["self_intersections"]),
            f"{d['rms'] / h:.4f}" if d else "",
            f"{d['normal']:.1e}" if d else "",
        ]


def part_file(part):
    return ROOT / "data" / f"{part}.py"


def ours(part, h, reps, path):
    best = None
    for _ in range(reps):
        path.unlink(missing_ok=True)
        seconds, code, _ = call([OURS, "mesh", part_file(part), "--size", repr(h), "--threads", 1, "-q", "-o", path],
                                good=(0, 1))
        best = min(seconds, best or seconds)
    return Mesh("**rvachev**", path, part, [best], " (exit code 1)" if code else "")


def gmsh(peers, part, h, wanted, reps, path):
    made = peers.make("gmsh", part, repr(h), wanted, reps, path)
    return Mesh("gmsh, exact B-rep", path, part, [made["seconds"]["B-rep"], made["seconds"]["meshing"]])


def fidget(part, n, reps, path):
    out = call([FIDGET, "mesh", PARTS[part][1], n, path, "--reps", reps])[2]
    return Mesh("fidget", path, part, [float(out)])


def remeshed(peers, part, source, source_path, h, wanted, reps, path):
    made = peers.make("remesh", source_path, repr(h), wanted, reps, path)
    return Mesh("fidget + pymeshlab", path, part, [*source.seconds, made["seconds"]["remeshing"]])


def rows(peers, part, n, reps):
    half, of_fidget, has_brep = PARTS[part]
    h = 2 * half / n
    at = lambda program: OUT / f"{part}-{n}-{program}.off"
    say(f"{part}, N = {n}: rvachev")
    us = ours(part, h, reps, at("rvachev"))
    yield row(n, us, us, h, "")
    if has_brep:
        say(f"{part}, N = {n}: gmsh")
        them = gmsh(peers, part, h, us.triangles, reps, at("gmsh"))
        alone = ratio(us, them, them.seconds[-1])
        yield row(n, us, them, h, f"{ratio(us, them, them.total):.2f} ({alone:.2f})")
    if of_fidget and n & (n - 1) == 0:
        say(f"{part}, N = {n}: fidget, pymeshlab")
        raw = fidget(part, n, reps, at("fidget"))
        yield row(n, us, raw, h, "")
        them = remeshed(peers, part, raw, at("fidget"), h, us.triangles, reps, at("pymeshlab"))
        yield row(n, us, them, h, f"{ratio(us, them, them.total):.2f}")


def ratio(us, them, seconds):
    """Our seconds per triangle by theirs."""
    return us.total / us.triangles / (seconds / them.triangles)


def row(n, us, mesh, h, last):
    return [str(n), mesh.program + mesh.note, *mesh.cells(h), last]


def line(cells):
    return "| " + " | ".join(cells) + " |"


# ----------------------------------------------------------------------------------------------------------- picture

def picture(peers, out):
    """Where each method of `rvachev compare` ends, side by side; says what `compare` measured there."""
    sheet, report = OUT / "compare.png", OUT / "compare.json"
    say("cube_with_holes: rvachev compare")
    call([OURS, "compare", part_file("cube_with_holes"), "--size", "0.15", "-q", "--png", sheet, "--json", report],
         good=(0, 1))
    stages = json.loads(report.read_text())["rows"]
    last = {stage["method"]: i for i, stage in enumerate(stages)}
    peers.make("picture", out, sheet, len(stages), *last.values())
    for method, i in last.items():
        check = stages[i]["check"]
        print(f"{method}: {check['triangles']} triangles, smallest angle {check['quality']['min_angle']:.1f}, "
              f"5th percentile {check['quality']['p05_angle']:.1f}, recall {check['features']['recall']:.3f}, "
              f"corners {check['features']['corners_found']}")


def main():
    if sys.version_info < (3, 10):
        fail("Python 3.10 or newer is needed")
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("parts", nargs="*", metavar="PART")
    options.add_argument("--cells", default="32,64,128", type=lambda s: [int(n) for n in s.split(",")])
    options.add_argument("--reps", default=3, type=int)
    options.add_argument("--picture", type=Path)
    options = options.parse_args()
    unknown = [p for p in options.parts if p not in PARTS]
    if unknown:
        fail(f"no part {', '.join(unknown)}; there are {', '.join(PARTS)}")
    if options.reps < 1 or min(options.cells) < 1:
        fail("--reps and --cells are at least 1")
    build()
    OUT.mkdir(parents=True, exist_ok=True)
    peers = Peers()
    if options.picture:
        picture(peers, options.picture)
        return
    for part in options.parts or PARTS:
        print(f"### {part}\n\n{line(COLUMNS)}\n{line(['---'] * len(COLUMNS))}", flush=True)
        for n in [MANY_CELLS] if part == "many_solids" else options.cells:
            for cells in rows(peers, part, n, options.reps):
                print(line(cells), flush=True)
        print(flush=True)


if __name__ == "__main__":
    main()
