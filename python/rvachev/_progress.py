"""Progress as one line on standard error."""

import sys

_WIDTH = 32


def line(stage: str, done: float) -> None:
    """Shows a stage and the share of it that is done, over what was shown before."""
    if sys.stderr is None:
        return
    full = round(_WIDTH * done)
    sys.stderr.write(f"\r{stage:>12} [{'=' * full}{' ' * (_WIDTH - full)}] {100 * done:3.0f}%")
    sys.stderr.flush()


def done() -> None:
    """Takes the line away."""
    if sys.stderr is None:
        return
    sys.stderr.write("\r" + " " * (_WIDTH + 20) + "\r")
    sys.stderr.flush()
