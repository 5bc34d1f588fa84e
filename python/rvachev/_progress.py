"""Progress on standard error: a bar of tqdm if that is installed, else one line of our own."""

import sys

_WIDTH = 32


class _Line:
    """Shows a stage and the share of it that is done, over what was shown before."""

    def line(self, stage: str, done: float) -> None:
        full = round(_WIDTH * done)
        sys.stderr.write(f"\r{stage:>12} [{'=' * full}{' ' * (_WIDTH - full)}] {100 * done:3.0f}%")
        sys.stderr.flush()

    def done(self) -> None:
        sys.stderr.write("\r" + " " * (_WIDTH + 20) + "\r")
        sys.stderr.flush()


class _Tqdm:
    """One bar, which each stage fills; taken away at the end."""

    def __init__(self, tqdm) -> None:
        # Times are of one stage and would mislead, so the bar has none.
        self._bar = tqdm(total=1.0, leave=False, bar_format="{desc}: {percentage:3.0f}%|{bar}|")

    def line(self, stage: str, done: float) -> None:
        self._bar.set_description_str(stage, refresh=False)
        self._bar.n = done
        self._bar.refresh()

    def done(self) -> None:
        self._bar.close()


class _Nothing:
    """Where there is no standard error, as in programs with windows only."""

    def line(self, stage: str, done: float) -> None:
        pass

    def done(self) -> None:
        pass


def bar():
    """What `progress=True` shows: one for each call, so calls of several threads know nothing of each other."""
    if sys.stderr is None:
        return _Nothing()
    try:
        import warnings

        with warnings.catch_warnings():
            # In notebooks without widgets tqdm says so, and shows its line of text.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
    except ImportError:
        return _Line()
    return _Tqdm(tqdm)
