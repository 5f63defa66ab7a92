"""Formats that are known but not read: a line says what the file is and how it becomes one that is."""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.formats.base import SplatData

_KSPLAT_HEADER = 4096


@dataclasses.dataclass(frozen=True)
class Unread:
    """A format that is not read.

    Attributes:
        name: Its name, as in "is NAME".
        do: Advice that follows the message.
        recognise: Whether a file's beginning is of this format.
        ending: File name ending by which a damaged file is still named; "" = none of its own.
        suffixes: None, because none of them can be given.
    """

    name: str
    do: str
    recognise: Callable[[bytes], bool]
    ending: str = ""
    suffixes: tuple[str, ...] = ()

    def matches(self, head: bytes) -> bool:
        """Return whether a file that begins so is of this format."""
        return self.recognise(head)

    def explain(self, path: Path) -> UserError:
        """The refusal of a file."""
        return UserError(f"{shorten(path)} is {self.name}, which is not read", do=self.do)

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Refuse the file.

        Raises:
            UserError: Always.
        """
        raise self.explain(path)


def _is_ksplat(head: bytes) -> bool:
    """Return whether the numbers of a header of version 0.1 make sense; it has no magic number."""
    if len(head) < _KSPLAT_HEADER or head[:2] != b"\x00\x01":
        return False
    most_sections, sections, most_splats, splats, compression = struct.unpack_from("<4IH", head, 4)
    return 1 <= sections <= most_sections <= 2**20 and 1 <= splats <= most_splats and compression <= 2


def _convert(suffix: str) -> str:
    return f"Convert it to PLY: `npx @playcanvas/splat-transform in{suffix} out.ply`"


UNREAD = (
    Unread("a .ksplat file (mkkellogg)", _convert(".ksplat"), _is_ksplat, ".ksplat"),
    Unread(
        "the index of a streamed SOG scene",
        "Give the meta.json of one of the folders that it names",
        lambda head: head.lstrip().startswith(b"{") and b'"lodLevels"' in head and b'"filenames"' in head,
    ),
    Unread(
        "an .spx file (Reall3D)",
        "Convert it to PLY with its own tool: `gsbox x2p -i in.spx -o out.ply`",
        lambda head: head.startswith(b"spx") and len(head) >= 128,
        ".spx",
    ),
)
"""Formats that are refused in words."""
