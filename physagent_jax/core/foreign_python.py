"""Programs of another Python: packages that this one cannot share, such as those that need an older NumPy."""

from __future__ import annotations

import dataclasses
import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten

_OWN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
_LAST_LINES = 3


@dataclasses.dataclass(frozen=True)
class Foreign:
    """Names for messages about another Python.

    Attributes:
        what: Who needs it.
        python, timeout: Options that name the Python and its longest time.
    """

    what: str
    python: str = "`python`"
    timeout: str = "`timeout`"


def find_python(python: object, told: Foreign, example: str) -> str:
    """The program that ``python`` names.

    Args:
        python: A path, or the name of a program.
        told: Names for messages.
        example: How it is given.

    Raises:
        UserError: It names none.
    """
    if python is None:
        raise UserError(
            f"{told.what} needs a Python that has its packages", do=f"Give {told.python}: {example}"
        )
    if not isinstance(python, str) or (found := shutil.which(os.path.expanduser(python))) is None:
        do = f"Give {told.python}: {example}"
        raise UserError(f"the Python of {told.what} is no program", got=shorten(repr(python)), do=do)
    return found


def run_python(
    python: str,
    arguments: Sequence[str],
    *,
    told: Foreign,
    folder: Path,
    timeout: float,
    script: str | None = None,
    environment: Mapping[str, str] | None = None,
) -> str:
    """Run another Python without this one's own paths; return what it prints.

    Args:
        python: The program.
        arguments: Its arguments.
        told: Names for messages.
        folder: Folder in which it runs.
        timeout: Longest time [s].
        script: Its standard input; None = there is none.
        environment: Further variables.

    Raises:
        UserError: It cannot be started, takes too long, or fails; with the last lines that it wrote.
    """
    inherited = {name: value for name, value in os.environ.items() if name not in _OWN}
    try:
        done = subprocess.run(
            [python, *arguments],
            input=script or "",
            env=inherited | dict(environment or {}),
            cwd=folder,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout,
        )
    except subprocess.TimeoutExpired:
        raise UserError(f"{told.what} took longer than {timeout:g} s", do=f"Raise {told.timeout}") from None
    except OSError as error:
        raise UserError(f"{told.what} cannot be started", got=shorten(error)) from None
    if done.returncode:
        last = " | ".join(done.stderr.strip().splitlines()[-_LAST_LINES:]) or "it says nothing"
        raise UserError(
            f"{told.what} failed with exit code {done.returncode}",
            got=shorten(last, 400),
            do=f"Mend the Python that {told.python} names",
        )
    return done.stdout
