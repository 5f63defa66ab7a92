"""The `physagent` command."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

from physagent_jax.cli.stopping import Stopped, allow_stopping
from physagent_jax.core.errors import UserError

_SPLATS = ("--save-splats", "--save_splats")
_SPLAT_FORMATS = ("ply", "spz", "glb")


def main(arguments: list[str] | None = None) -> int:
    """Run a command; return the exit code: 0, or 2 for input that a person can mend.

    ``--debug`` anywhere on the line shows the traceback of an error.
    """
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in arguments
    arguments = [argument for argument in arguments if argument != "--debug"]
    simulates = _is_computing(arguments) and arguments[0] in ("run", "simulate")
    try:
        with allow_stopping() if simulates else nullcontext():
            return _execute(arguments, simulates)
    except BrokenPipeError:  # whoever reads the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except (UserError, OSError, MemoryError, ModuleNotFoundError) as error:
        if debug:
            raise
        print(f"physagent: {_to_user_error(error)}", file=sys.stderr)
        return 2
    except KeyboardInterrupt as stop:
        resumes = "; the same command takes the run up again" if arguments[:1] == ["run"] else ""
        print(f"physagent: stopped{resumes}", file=sys.stderr)
        return stop.exit_code if isinstance(stop, Stopped) else 130


def _execute(arguments: list[str], simulates: bool) -> int:
    if arguments[:1] == ["doctor"]:
        return _examine(arguments)
    from physagent_jax.cli.text import accept_any_character, check_arguments

    accept_any_character()
    check_arguments(arguments)
    if _is_computing(arguments):
        from physagent_jax.cli import environment

        environment.prepare()
    if simulates:
        from physagent_jax.simulation.ahead import compile_ahead

        compile_ahead()  # while the rest is imported
    from physagent_jax.cli.commands import COMMANDS, DESCRIPTION
    from physagent_jax.cli.console import tell_warnings_plainly

    tell_warnings_plainly()
    return _parse(COMMANDS, join_options(arguments) or ["--help"], DESCRIPTION)()


def _parse(commands: dict[str, Any], arguments: list[str], description: str = "") -> Callable[[], int]:
    import tyro

    return tyro.extras.subcommand_cli_from_dict(
        commands,
        prog="physagent",
        description=description,
        args=arguments,
        config=(tyro.conf.EnumChoicesFromValues, tyro.conf.FlagCreatePairsOff, tyro.conf.DisallowNone),
    )


def _examine(arguments: list[str]) -> int:
    """Run `physagent doctor`, which works where packages are missing that other commands need.

    Without tyro its arguments are not checked.
    """
    from physagent_jax.cli.doctor import Doctor

    try:
        from physagent_jax.cli.text import accept_any_character, check_arguments

        accept_any_character()
        check_arguments(arguments)
        command = _parse({"doctor": Doctor}, arguments)
    except ImportError:
        command = Doctor(json="--json" in arguments)
    return command()


def join_options(arguments: list[str]) -> list[str]:
    """Glues options to their values where a parser would be mistaken.

    ``--up -y`` becomes ``--up=-y``, because the axis looks like another option; ``--save-splats`` becomes
    ``--save-splats=ply`` unless a format follows.
    """
    glued: list[str] = []
    for argument in arguments:
        if glued and (glued[-1] == "--up" or (glued[-1] in _SPLATS and argument in _SPLAT_FORMATS)):
            glued[-1] = f"{glued[-1]}={argument}"
        else:
            glued.append(argument)
    return [f"{argument}=ply" if argument in _SPLATS else argument for argument in glued]


def _is_computing(arguments: list[str]) -> bool:
    """Return whether a command needs devices and caches; help texts and schemas come whatever state those are in."""
    helped = not arguments or bool({"-h", "--help"} & set(arguments))
    return not helped and arguments[0] not in ("schema", "report", "doctor", "models", "study")


def _to_user_error(error: UserError | OSError | MemoryError | ModuleNotFoundError) -> UserError:
    """Convert an operating system's refusal that no reader or writer has foreseen into a message."""
    if isinstance(error, UserError):
        return error
    if isinstance(error, ModuleNotFoundError):
        return UserError(f"the package `{error.name}` is missing", do="`physagent doctor` says how to get it")
    if isinstance(error, MemoryError):
        return UserError("the memory does not suffice", do="Use fewer particles, frames, pixels or cells")
    what = "the operating system refuses"
    if error.filename is not None:
        name = str(error.filename)
        what = f"cannot use {name if len(name) < 200 else name[:200] + '...'}"
    return UserError(what, got=error.strerror or error, do="Mend this and give the command again")
