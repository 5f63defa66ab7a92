"""The `physagent` command."""

from __future__ import annotations

import os
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from physagent_jax.cli.stopping import Stopped, stoppable
from physagent_jax.core.errors import UserError

_CACHE_VARIABLE = "PHYSAGENT_COMPILE_CACHE"


def main(arguments: list[str] | None = None) -> int:
    """Runs a command; returns the exit code: 0, or 2 for input that a person can mend.

    ``--debug`` anywhere on the line shows the traceback of an error.
    """
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in arguments
    arguments = [argument for argument in arguments if argument != "--debug"]
    simulates = arguments[:1] in (["run"], ["simulate"]) and not {"-h", "--help"} & set(arguments)
    try:
        with stoppable() if simulates else nullcontext():
            return _execute(arguments, simulates)
    except BrokenPipeError:  # whoever reads the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except (UserError, OSError, MemoryError) as error:
        if debug:
            raise
        print(f"physagent: {_as_user_error(error)}", file=sys.stderr)
        return 2
    except KeyboardInterrupt as stop:
        resumes = "; the same command takes the run up again" if arguments[:1] == ["run"] else ""
        print(f"physagent: stopped{resumes}", file=sys.stderr)
        return stop.exit_code if isinstance(stop, Stopped) else 130


def _as_user_error(error: UserError | OSError | MemoryError) -> UserError:
    """What to tell; the one place for refusals of the operating system that no reader or writer has foreseen."""
    if isinstance(error, UserError):
        return error
    if isinstance(error, MemoryError):
        return UserError("the memory does not suffice", do="Use fewer particles, frames, pixels or cells")
    what = "the operating system refuses" if error.filename is None else f"cannot use {error.filename!r}"
    return UserError(what, got=error.strerror or error, do="Mend this and give the command again")


def _execute(arguments: list[str], simulates: bool) -> int:
    enable_compile_cache()
    if simulates:
        from physagent_jax.kernels import ahead

        ahead.begin()  # while the rest is imported
    import tyro

    from physagent_jax.cli.commands import COMMANDS, DESCRIPTION

    command = tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="physagent",
        description=DESCRIPTION,
        args=joined(arguments) or ["--help"],
        config=(tyro.conf.EnumChoicesFromValues, tyro.conf.FlagCreatePairsOff, tyro.conf.DisallowNone),
    )
    return command()


def joined(arguments: list[str]) -> list[str]:
    """Glues ``--up -y`` to ``--up=-y``: a parser would take the axis for another option."""
    glued: list[str] = []
    for argument in arguments:
        if glued and glued[-1] == "--up":
            glued[-1] = f"--up={argument}"
        else:
            glued.append(argument)
    return glued


def enable_compile_cache() -> None:
    """Keeps compiled programs between processes, so that only the first run pays for compilation.

    ``PHYSAGENT_COMPILE_CACHE`` names another folder, or turns it off with ``off``. A folder set through
    JAX's own configuration is left alone. The folder is private to the user: JAX loads code from it.
    """
    setting = os.environ.get(_CACHE_VARIABLE, "")
    if setting.lower() in ("off", "0", "no", "none", "false"):
        return
    import jax

    config: Any = jax.config  # its flags are not typed
    if config.jax_compilation_cache_dir is not None:
        return
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = Path(setting) if setting else home / "physagent_jax" / "compiled"
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError:
        return  # a read-only home costs compile time, nothing else
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
