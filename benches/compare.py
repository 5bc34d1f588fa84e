#!/usr/bin/env python3
"""Whether a commit made stages slower: builds the benches of two commits, runs them in turns, and prints ratios of their times.

    python3 benches/compare.py BASE HEAD [--bench stages] [--filter X] [--rounds 3] [--slower 1.10]

Needs git and cargo, and nothing of Python but its standard library. Both commits are checked out and built below
target/compare/. Each round runs both programs, the other one first each time. A stage's time in a round is criterion's median.
The ratio is the median over the rounds of the head divided by that of the base; the spread is the least and the largest ratio
within a round.

A stage counts as slower if the ratio is above --slower and no round of the head was as fast as any of the base.

Exit codes: 0: no stage is slower; 1: some are; 2: bad input, or a commit whose bench cannot be built or run.
"""

import argparse
import json
import os
import re
import shutil
import signal
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


class Refused(Exception):
    """What ends the command with code 2."""


def done(args, **kwargs):
    """Standard output of a command that must succeed."""
    try:
        run = subprocess.run(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False, **kwargs)
    except OSError as e:
        raise Refused(f"{args[0]}: {e}") from e
    if run.returncode != 0:
        tail = "\n".join(run.stderr.strip().splitlines()[-20:])
        raise Refused(f"{' '.join(map(str, args))} failed:\n{tail}")
    return run.stdout


def commit(name):
    """The full name of a commit."""
    try:
        return done(["git", "rev-parse", "--verify", "--quiet", "--end-of-options", f"{name}^{{commit}}"], cwd=ROOT).strip()
    except Refused as e:
        raise Refused(f"{name!r} is no commit of this repository") from e


# ------------------------------------------------------------------------------------------------------------ building


def drop_tree(tree):
    """Takes a worktree away, also what is left of one that a run could not take away."""
    subprocess.run(["git", "worktree", "remove", "--force", str(tree)], cwd=ROOT, capture_output=True, check=False)
    shutil.rmtree(tree, ignore_errors=True)
    subprocess.run(["git", "worktree", "prune"], cwd=ROOT, capture_output=True, check=False)


def lend(bench, head, base):
    """Gives the base the bench of the head, with its entry and the dependency on criterion."""
    shutil.copy(head / "benches" / f"{bench}.rs", base / "benches" / f"{bench}.rs")
    manifest = base / "Cargo.toml"
    text = manifest.read_text()
    if not re.search(r"^criterion\s*=", text, re.M):
        line = re.search(r"^criterion\s*=.*$", (head / "Cargo.toml").read_text(), re.M)
        if line and "[dev-dependencies]\n" in text:
            text = text.replace("[dev-dependencies]\n", f"[dev-dependencies]\n{line[0]}\n", 1)
    if not re.search(rf'^name = "{re.escape(bench)}"$', text, re.M):
        text += f'\n[[bench]]\nname = "{bench}"\nharness = false\n'
    manifest.write_text(text)


def build(tree, target, bench):
    """The bench's program."""
    env = {**os.environ, "CARGO_TARGET_DIR": str(target)}
    args = ["cargo", "bench", "--bench", bench, "--no-run", "--message-format", "json-render-diagnostics"]
    for line in done(args, cwd=tree, env=env).splitlines():
        said = json.loads(line) if line.startswith("{") else {}
        if said.get("reason") == "compiler-artifact" and said.get("executable") and said["target"]["name"] == bench:
            return said["executable"]
    raise Refused(f"cargo names no program of the bench {bench}")


# ------------------------------------------------------------------------------------------------------------- running


def measure(program, tree, folder, chosen):
    """Seconds of each stage, by its name: medians of criterion, which leaves them in a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    done([program, "--bench", "--noplot", *chosen], cwd=tree, env={**os.environ, "CRITERION_HOME": str(folder)})
    found = {}
    for path in sorted(folder.rglob("new/estimates.json")):
        name = json.loads((path.parent / "benchmark.json").read_text())["full_id"]
        found[name] = json.loads(path.read_text())["median"]["point_estimate"] / 1e9
    return found


def row(name, base, head, slower):
    """A line of the table, and whether the stage is slower; times are seconds of the rounds, empty where there is no such stage."""
    if not base or not head:
        only = "head" if head else "base"
        return f"| {name} | | | only in {only} | | |", False
    ratio = statistics.median(head) / statistics.median(base)
    each = [h / b for b, h in zip(base, head)]
    apart = min(head) > max(base)
    is_slower = ratio > slower and apart
    faster = ratio < 1 / slower and max(head) < min(base)
    word = "**slower**" if is_slower else "faster" if faster else ""
    times = f"{1e3 * statistics.median(base):.2f} | {1e3 * statistics.median(head):.2f}"
    return f"| {name} | {times} | {ratio:.3f} | {min(each):.3f} to {max(each):.3f} | {word} |", is_slower


def compare(options):
    if options.rounds < 1 or not options.slower > 0:
        raise Refused("--rounds must be at least 1, and --slower positive")
    if not re.fullmatch(r"[A-Za-z0-9_-]+", options.bench):
        raise Refused(f"{options.bench!r} is no name of a bench")
    names = [commit(options.base), commit(options.head)]
    below = ROOT / "target" / "compare"
    sides = [below / "base", below / "head"]
    trees = [side / "tree" for side in sides]
    chosen = [options.filter] if options.filter else []
    try:
        for tree, name in zip(trees, names):
            drop_tree(tree)
            tree.parent.mkdir(parents=True, exist_ok=True)
            done(["git", "worktree", "add", "--detach", "--force", str(tree), name], cwd=ROOT)
        has = [(tree / "benches" / f"{options.bench}.rs").exists() for tree in trees]
        if not has[1]:
            raise Refused(f"{options.head} has no benches/{options.bench}.rs")
        if not has[0]:
            print(f"{options.base} has no benches/{options.bench}.rs: that of {options.head} is used for both.\n")
            lend(options.bench, trees[1], trees[0])
        programs = []
        for side, tree in zip(sides, trees):
            print(f"building {side.name}", file=sys.stderr)
            programs.append(build(tree, side / "target", options.bench))
        rounds = [[], []]
        for k in range(options.rounds):
            for i in (0, 1) if k % 2 == 0 else (1, 0):
                print(f"round {k + 1} of {options.rounds}: {sides[i].name}", file=sys.stderr)
                rounds[i].append(measure(programs[i], trees[i], sides[i] / "criterion", chosen))
    finally:
        for tree in trees:
            drop_tree(tree)
    stages = sorted({name for side in rounds for one in side for name in one})
    if not stages:
        raise Refused("no stage was measured: the filter fits none, or the bench is none of criterion's")
    print(f"Base {names[0][:10]}, head {names[1][:10]}, {options.rounds} rounds.\n")
    print("| stage | base, ms | head, ms | head / base | in rounds | |\n|---|---|---|---|---|---|")
    worse = 0
    for stage in stages:
        times = [[one[stage] for one in side if stage in one] for side in rounds]
        line, is_slower = row(stage, *times, options.slower)
        print(line)
        worse += is_slower
    print(f"\n{worse} of {len(stages)} stages are slower by more than a factor of {options.slower:g}.")
    return 1 if worse else 0


def main():
    # Worktrees are taken away also where somebody ends this.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", help="a commit, such as main")
    parser.add_argument("head", help="the commit that is judged")
    parser.add_argument("--bench", default="stages", help="a bench that uses criterion")
    parser.add_argument("--filter", help="only stages whose names fit this regular expression")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--slower", type=float, default=1.10, help="the largest ratio that is not called slower")
    try:
        return compare(parser.parse_args())
    except Refused as e:
        print(f"error: {e}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
