"""How much of a mesh is made side by side: the command with one thread and with several, in turns.

    python3 benches/threads.py [MODEL:SIZE ...] [--threads 2] [--rounds 5] [--program target/release/rvachev]

Without models those of `data/` below are meshed. Needs Python 3.10 or newer and a release build of rvachev, and as many idle
cores as threads. Results are the same bytes for any number of threads, which is checked.

Definitions.

    ratio    least seconds of the whole command with one thread by those with several
    serial   the share of the work that one thread does alone, if the rest were shared out evenly: by Amdahl's law it is
             (n / ratio - 1) / (n - 1) with n threads
"""
import argparse
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MODELS = ["data/cube_with_holes.py:0.0193", "data/gyroid_block.py:0.0193", "data/thread.py:1%", "data/many_solids.py:1%"]


def seconds(program, model, size, threads, out):
    began = time.monotonic()
    command = [program, "mesh", model, "--size", size, "--threads", str(threads), "-q", "-o", out]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"threads.py: {model}: {done.stderr.strip()}")
    return time.monotonic() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", default=[str(ROOT / m) for m in MODELS], metavar="MODEL:SIZE")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--program", type=Path, default=ROOT / "target" / "release" / "rvachev")
    args = parser.parse_args()
    if args.threads < 2 or args.rounds < 1:
        parser.error("--threads is at least 2, --rounds at least 1")
    if not args.program.exists():
        parser.error(f"no program {args.program}; run `cargo build --release` first")
    print("| model | 1 thread, s | " + f"{args.threads} threads, s | ratio | serial |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        outs = [Path(folder) / f"{k}.stl" for k in range(2)]
        for given in args.models:
            model, _, size = given.rpartition(":")
            rounds = [[seconds(args.program, model, size, n, out) for n, out in zip((1, args.threads), outs)]
                      for _ in range(args.rounds)]
            if outs[0].read_bytes() != outs[1].read_bytes():
                raise SystemExit(f"threads.py: {model}: other bytes with {args.threads} threads")
            one, many = (min(r[k] for r in rounds) for k in range(2))
            n, ratio = args.threads, one / many
            print(f"| {Path(model).name}, {size} | {one:.2f} | {many:.2f} | {ratio:.2f} | {(n / ratio - 1) / (n - 1):.2f} |", flush=True)


if __name__ == "__main__":
    main()
