"""Exceptions and warnings."""

from __future__ import annotations


class Error(Exception):
    """What the library raises; the kinds below say more."""


class InputError(Error):
    """What was given cannot be used as it is.

    Attributes, None where they are not known: `file`; `line` and `column`, from 1; `point`, where in space, (x, y, z);
    `help`, what would be right.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        point: tuple[float, float, float] | None = None,
        help: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column
        self.point = point
        self.help = help

    def __str__(self) -> str:
        message = super().__str__()
        return f"{message} ({self.help})" if self.help else message

    def __reduce__(self):
        return (_again, (type(self), self.args, self.__dict__))


class Failed(Error):
    """What was given is good, but no mesh of the asked kind was reached, or a file could not be written."""


class Cancelled(Error, KeyboardInterrupt):
    """Stopped by Ctrl-C, or by the event given as `cancel`."""


class Shortfall(UserWarning):
    """A mesh falls short of what was asked; `mesh.shortfalls` lists all."""


class Told(UserWarning):
    """Worth knowing: a group no face answers to, a solid cut off by its domain."""


class NotTraced(UserWarning):
    """A function could not be read as a formula and is called instead."""


def _again(kind, args, attributes):
    error = kind(*args)
    error.__dict__.update(attributes)
    return error
