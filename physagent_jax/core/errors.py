"""The exception for what a person can mend: bad input, and a package that is not installed."""

from __future__ import annotations


class UserError(ValueError):
    """Bad input, told in one line: what is wrong, what was got, what to do.

    The command line prints the message without a traceback and exits with code 2;
    library callers catch it like any ``ValueError``.

    Args:
        what: What is wrong, naming the argument, file or field.
        got: The offending value, if showing it helps.
        do: What to do about it.
    """

    def __init__(self, what: str, *, got: object = None, do: str = ""):
        self.what, self.got, self.do = what, got, do
        message = what if got is None else f"{what} (got {got})"
        message = message.rstrip(".") + "."
        if do:
            message += f" {do}" if do.endswith("?") else f" {do.rstrip('.')}."
        super().__init__(" ".join(message.split()))


class MissingPackageError(UserError):
    """A requested feature needs a package that is not installed, whatever the input.

    Args:
        what: What needs it, and the package.
        extra: Extra of this project, with which it comes.
    """

    def __init__(self, what: str, extra: str = ""):
        super().__init__(what, do=f"Install the extra: pip install 'physagent-jax[{extra}]'" if extra else "")
