"""What calls from Python cost: a traced function against the same part file, and a call against the command, as ratios of one run.

    cargo build --release && pip install python/ && python benches/calls/run.py [--rounds 6] [--program target/release/rvachev]

The least time of so many rounds counts for each, taken in turn. Needs the package and a release build of the command.
"""

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import rvachev as rv
from rvachev import box, cylinder, solid

R = 0.4
PART = f"""
bores = union(cylinder({R}, axis="x"), cylinder({R}, axis="z")).name("bores")
dent = solid(0.7**2 - x**2 - y**2 - (z - 1.4)**2).name("dent")
part(box(size=(2, 2, 2)).name("body") - bores - dent)
"""
SMALL = "part(box(size=(1, 1, 1)) - cylinder(0.2))\n"


def least(calls, clock, rounds):
    """The least time of each call."""
    times = [float("inf")] * len(calls)
    for _ in range(rounds):
        for i, call in enumerate(calls):
            started = clock()
            call()
            times[i] = min(times[i], clock() - started)
    return times


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--rounds", type=int, default=6)
    options.add_argument("--program", default=str(Path(__file__).parents[2] / "target/release/rvachev"))
    options = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        part, small = folder / "part.py", folder / "small.py"
        part.write_text(PART)
        small.write_text(SMALL)

        def traced():
            bores = rv.union(cylinder(R, axis=a) for a in "xz").name("bores")
            dent = solid(lambda x, y, z: 0.7**2 - x**2 - y**2 - (z - 1.4) ** 2).name("dent")
            return rv.Part(box(size=(2, 2, 2)).name("body") - bores - dent).mesh(size="4%", threads=1)

        def command():
            call = [options.program, "mesh", small, "-o", folder / "a.stl", "--size", "10%"]
            subprocess.run(call, check=True, capture_output=True)

        def call():
            rv.mesh(small, size="10%").write(folder / "b.stl")

        file, function = least([lambda: rv.mesh(part, size="4%", threads=1), traced], time.process_time, options.rounds)
        print(f"traced function / part file: {function / file:.2f} ({1e3 * function:.1f} ms of CPU / {1e3 * file:.1f} ms)")
        one, other = least([command, call], time.perf_counter, options.rounds)
        print(f"call - command: {1e3 * (other - one):.1f} ms ({1e3 * other:.1f} ms / {1e3 * one:.1f} ms)")


if __name__ == "__main__":
    main()
