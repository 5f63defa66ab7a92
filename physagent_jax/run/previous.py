"""The run that another one replaces: moved aside by renaming, kept until the new one stands.

Its manifest is the first file to leave and the last to return, so that a process may be killed at any moment: with no
manifest in the folder and one in ``.previous``, the move was cut short and is undone.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

from physagent_jax.core.files import explain_write_error, remove_leftovers

MANIFEST = "manifest.json"
_ASIDE = ".previous"


def exists(path: Path) -> bool:
    """Return whether a replaced run is kept in the run folder ``path``."""
    return (path / _ASIDE / MANIFEST).is_file()


def find_manifest(path: Path) -> Path:
    """The path of the replaced run's manifest."""
    return path / _ASIDE / MANIFEST


def move_aside(path: Path, files: Iterable[str]) -> None:
    """Move a run's files out of the way; ``files`` are relative to its folder."""
    _move(path, path / _ASIDE, [MANIFEST, *(name for name in files if name != MANIFEST)])


def restore(path: Path, files: Iterable[str]) -> None:
    """Put the replaced run's files back."""
    _move(path / _ASIDE, path, [*(name for name in files if name != MANIFEST), MANIFEST])


def drop(path: Path, files: Iterable[str]) -> None:
    """Remove the replaced run's files."""
    remove(path / _ASIDE, files)


def remove(folder: Path, files: Iterable[str]) -> None:
    """Remove a run's files, its manifest last, and the folders that are empty then."""
    names = [*(name for name in files if name != MANIFEST), MANIFEST]
    for name in names:
        remove_leftovers(folder / name)
        with contextlib.suppress(FileNotFoundError):
            (folder / name).unlink()
    _remove_empty(folder, names)


def _move(source: Path, target: Path, names: list[str]) -> None:
    for name in names:
        if not os.path.lexists(source / name):
            continue
        try:
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            os.replace(source / name, target / name)
        except OSError as error:
            raise explain_write_error(target / name, error) from error
    _remove_empty(source, names)


def _remove_empty(folder: Path, names: list[str]) -> None:
    """Remove the folders that held ``names`` if nothing is left in them, ``folder`` too if it is `_ASIDE`."""
    inside = {folder / place for name in names for place in Path(name).parents}
    for place in sorted(inside, key=lambda place: len(place.parts), reverse=True):
        if place != folder or folder.name == _ASIDE:
            with contextlib.suppress(OSError):
                place.rmdir()
