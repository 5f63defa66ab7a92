"""Text in and out of the terminal, whatever its encoding, and arguments that no option could mean."""

from __future__ import annotations

import codecs
import io
import sys
import unicodedata
from collections.abc import Sequence

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten

_LONGEST = 4096  # bytes of an argument: as long as a path may be on Linux, and more than a sentence needs
_RENAMED = {"--semantic": "--reader"}  # options of earlier versions
_HANDLER = "physagent.stand_in"  # how Python calls what replaces characters that an encoding lacks
_STAND_INS = {
    "·": "-", "✓": "+", "✗": "x", "…": "...", "×": "x", "–": "-", "—": "-", "‘": "'", "’": "'", "“": '"', "”": '"',
    "°": " degrees", "²": "^2", "³": "^3", "µ": "u", "ν": "nu", "ρ": "rho", "→": "->", "≤": "<=", "≥": ">=", "•": "*",
    "─": "-", "━": "-", "│": "|", "┃": "|",
}  # fmt: skip


def accept_any_character() -> None:
    """Make standard output and error take any character.

    A terminal in plain ASCII gets stand-ins: `x` for a cross, `^3` for a cube, an escape for what has none.
    """
    codecs.register_error(_HANDLER, _replace_lacking)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_HANDLER)


def check_arguments(arguments: Sequence[str]) -> None:
    """Refuse arguments that no option could mean, and no file could be called.

    Raises:
        UserError: One is empty, too long, holds a zero byte, or bytes that are no text in the terminal's encoding.
    """
    for argument in arguments:
        if (old := argument.partition("=")[0]) in _RENAMED:
            new = _RENAMED[old]
            raise UserError(
                f"`{old}` is called `{new}` now", got=argument, do=f"Pass {new} grammar, model or both"
            )
        shown = shorten(repr(argument), 60)
        if not argument or (argument.startswith("--") and argument.endswith("=")):
            raise UserError("an argument is empty", got=shown, do="Leave the option out, or give it a value")
        if "\0" in argument:
            raise UserError("an argument holds a zero byte", got=shown, do="Take it out")
        if len(argument.encode("utf-8", "surrogatepass")) > _LONGEST:
            raise UserError(f"an argument is longer than {_LONGEST:,} bytes", got=shown, do="Shorten it")
        try:
            argument.encode("utf-8")
        except UnicodeEncodeError:  # Python keeps such bytes as halves of characters
            raise UserError(
                "the command line holds bytes that are no text in this terminal's encoding",
                got=shorten(ascii(argument), 80),
                do="Type it anew, use other file names, or set a UTF-8 locale (`export LC_ALL=C.UTF-8`)",
            ) from None


def _replace_lacking(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(map(_spell_in_ascii, lacking)), error.end


def _spell_in_ascii(character: str) -> str:
    if character in _STAND_INS:
        return _STAND_INS[character]
    if unicodedata.name(character, "").startswith("BOX DRAWINGS"):
        return "+"
    plain = (
        unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    )  # an e for an accented one
    return plain or ascii(character)[1:-1]
