"""Large random trees, meshed one after the other.

    python3 benches/trees/run.py [--from 0] [--to 300] [--size 6%] [--limit 60] [--program target/release/rvachev]
                                 [--folder target/trees]

A tree has 20 to 60 solids of every kind: boxes, balls, cylinders, cones, tori, ellipsoids, prisms, bodies of revolution, sheets of
least area, formulas; half of the trees on a grid of a quarter, so that faces coincide, some of the others off it by 1e-6 and 1e-9.
Half of the solids are joined, a third cut out, a twelfth blended, the rest intersected, each with all that was before it. The same
number gives the same tree. Needs Python 3.10 or newer and a release build of rvachev.

Definitions.

    exact   exit code 0, by the method leaf, with nothing that falls short and no warning
    sound   exit code 0
    time    CPU seconds of the whole command with one thread; a tree that is not done after `--limit` counts as that

One line is printed for each tree that is not exact, was tried more than once, or took more than five seconds; then what all took.
"""
import argparse
import json
import random
import resource
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SLOW = 5
KINDS = (
    ["box"] * 5 + ["ball"] * 3 + ["cylinder"] * 5 + ["cone", "torus"] * 2
    + ["ellipsoid", "prism", "cut", "formula", "formula", "sheet", "revolved", "turned"]
)


class Maker:
    """Writes solids with numbers from one seed."""

    def __init__(self, rng):
        self.rng = rng
        self.on_grid = rng.random() < 0.5

    def number(self, lo, hi):
        x = self.rng.uniform(lo, hi)
        if self.on_grid and self.rng.random() < 0.6:
            return round(x / 0.25) * 0.25
        return round(x + self.rng.choice([0, 0, 0, 1e-6, 1e-9]), 9)

    def length(self, lo, hi):
        return self.number(lo, hi) or 0.5

    def at(self):
        return "({}, {}, {})".format(*(self.number(-2, 2) for _ in range(3)))

    def axis(self):
        turned = "({}, {}, {})".format(*(round(self.rng.uniform(-1, 1), 3) for _ in range(3)))
        return self.rng.choice(['"x"', '"y"', '"z"', '"z"', turned])

    def box(self):
        sides = ", ".join(str(self.length(0.3, 2)) for _ in range(3))
        return f"box(size=({sides}), at={self.at()})"

    def solid(self):
        kind, s = self.rng.choice(KINDS), self.length
        if kind == "box":
            return self.box()
        if kind == "turned":
            return f"{self.box()}.rotate({self.rng.choice([17, 30, 45, 90])}, axis={self.axis()})"
        if kind == "ball":
            return f"sphere({s(0.3, 1.2)}, at={self.at()})"
        if kind == "cylinder":
            return f"cylinder({s(0.15, 0.8)}, axis={self.axis()}, at={self.at()}, height={s(0.4, 3)})"
        if kind == "cone":
            top = self.rng.choice([0, 0.2, 0.25])
            return f"cone({s(0.3, 0.9)}, {top}, {s(0.5, 2)}, axis={self.axis()}, at={self.at()})"
        if kind == "torus":
            return f"torus({s(0.5, 1.2)}, {s(0.1, 0.35)}, axis={self.axis()}, at={self.at()})"
        if kind == "ellipsoid":
            return f"ellipsoid(({s(0.3, 1)}, {s(0.3, 1)}, {s(0.3, 1)}), at={self.at()})"
        if kind == "prism":
            corners = f"(0, 0), ({s(0.5, 1.5)}, 0), ({s(0.3, 1.2)}, {s(0.4, 1.3)}), (0, {s(0.4, 1)})"
            return f"extrude([{corners}], height={s(0.3, 1.5)}, at={self.at()})"
        if kind == "revolved":
            return f"revolve([(0.25, -0.5), ({s(0.6, 1.2)}, -0.5), ({s(0.4, 1.2)}, 0.5)]).move({self.at()})"
        if kind == "cut":
            tilt = f"({round(self.rng.uniform(-1, 1), 2)}, {round(self.rng.uniform(-1, 1), 2)}, 1)"
            return f"(box(size=(1.5, 1.5, 1.5), at={self.at()}) & half_space({tilt}, at={self.at()}))"
        if kind == "sheet":
            name = self.rng.choice(["gyroid", "schwarz_p", "diamond"])
            sheet = f"{name}({s(0.8, 1.6)}, {round(self.rng.uniform(0.08, 0.25), 3)})"
            return f"({sheet} & sphere({s(0.6, 1.1)}, at={self.at()}))"
        return self.formula()

    def formula(self):
        a, b = self.length(-1, 1), self.length(-1, 1)
        return self.rng.choice([
            f"(solid(z <= 0.3*sin({3*a}*x)*cos({3*b}*y)) & box(size=(2, 2, 2), at={self.at()}))",
            f"solid((x - {a})**4 + (y - {b})**4 + z**4 <= {self.length(0.2, 1)})",
            f"solid(exp(-((x - {a})**2 + y**2 + z**2)/0.3) + exp(-(x**2 + (y - {b})**2 + z**2)/0.3) >= 0.4)",
            f"(solid(sqrt((x - {a})**2 + y**2) <= 0.4 + 0.1*sin(3*z)) & box(size=(3, 3, 2)))",
        ])


def tree(seed):
    """The text of a part file."""
    rng = random.Random(seed)
    make = Maker(rng)
    lines = [f's0 = ({make.solid()}).name("p0")']
    for i in range(1, rng.randint(20, 60)):
        lines.append(f'p{i} = ({make.solid()}).name("p{i}")')
        before, how = f"s{i - 1}", rng.random()
        if how < 0.5:
            joined = f"{before} | p{i}"
        elif how < 0.85:
            joined = f"{before} - p{i}"
        elif how < 0.93:
            joined = f"blend({before}, p{i}, 0.1)"
        else:
            joined = f"{before} & (p{i} | box(size=(3.5, 3.5, 3.5)))"
        lines.append(f"s{i} = {joined}")
    lines.append(f"part(s{i})")
    return "\n".join(lines) + "\n"


def meshed(part, args):
    """Exit code, CPU seconds, the report and what was printed of one tree."""
    report = part.with_suffix(".json")
    report.unlink(missing_ok=True)
    command = [args.program, "mesh", part, "--size", args.size, "--threads", "1"]
    command += ["-o", part.with_suffix(".ply"), "--report", report]

    def limited():
        resource.setrlimit(resource.RLIMIT_CPU, (args.limit, args.limit))

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, preexec_fn=limited)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    told = json.loads(report.read_text()) if report.exists() else {}
    return done.returncode, cpu, told, done.stdout + done.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--from", type=int, default=0, dest="first")
    parser.add_argument("--to", type=int, default=300, dest="last")
    parser.add_argument("--size", default="6%")
    parser.add_argument("--limit", type=int, default=60)
    parser.add_argument("--program", type=Path, default=ROOT / "target" / "release" / "rvachev")
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "trees")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    times, exact, sound = [], 0, 0
    for seed in range(args.first, args.last):
        part = args.folder / f"tree{seed}.py"
        part.write_text(tree(seed))
        code, cpu, told, printed = meshed(part, args)
        times.append(cpu)
        sound += code == 0
        flaws = [line for line in printed.splitlines() if line.startswith(("falls short", "warning", "error"))]
        is_exact = code == 0 and told.get("method") == "leaf" and not flaws
        exact += is_exact
        attempts = len(told.get("attempts", []))
        if not is_exact or attempts > 1 or cpu > SLOW:
            print(f"tree {seed}: exit code {code}, {cpu:.1f} s, {attempts} attempts", *flaws[:1], flush=True)
    times.sort()
    share = [sum(t > limit for t in times) for limit in (1, 5, 20)]
    print(f"{len(times)} trees: {sound} sound, {exact} exact; seconds: median {times[len(times) // 2]:.2f}, "
          f"most {times[-1]:.1f}; above 1, 5, 20 s: {share}")


if __name__ == "__main__":
    main()
