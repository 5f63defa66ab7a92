"""Files of other people that sentences are tried on: pinned by hash, fetched, never in the repository."""

from __future__ import annotations

import dataclasses
import hashlib
import shutil
import urllib.request
from collections.abc import Iterable
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import replace_file

_SITE = "https://raw.githubusercontent.com/"
_SECONDS = 60  # that a connection may be silent


@dataclasses.dataclass(frozen=True)
class PinnedFile:
    """A file of somebody else that sentences are tried on.

    Attributes:
        name: Its name, as it was published or as a person would call it.
        folder: Repository, commit and folder that it is in.
        sha256: Hash of the whole file.
        credit: Kind of asset, author and licence.
        published: The name that it was published under; empty = its own.
    """

    name: str
    folder: str
    sha256: str
    credit: str
    published: str = ""

    @property
    def url(self) -> str:
        """The address of the file at its commit."""
        return f"{_SITE}{self.folder}/{self.published or self.name}"

    def is_in(self, path: Path) -> bool:
        """Return whether ``path`` is this very file."""
        return path.is_file() and hash_file(path) == self.sha256


def hash_file(path: Path) -> str:
    """The sha256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def collect(files: Iterable[PinnedFile], into: Path, folder: Path | None = None) -> list[Path]:
    """Put the files into a folder: those that are there stay, the others are copied or downloaded.

    Args:
        files: The files that are wanted.
        into: The folder that they are put into.
        folder: Folder with copies, looked through with all below it; None = download.

    Raises:
        UserError: A file is not to be had, or is another one than was pinned.
    """
    missing = [file for file in files if not file.is_in(into / file.name)]
    copies = {hash_file(path): path for path in _list_files(folder)} if folder and missing else {}
    for file in missing:
        with replace_file(into / file.name) as temporary:
            if folder is None:
                _download(file, temporary)
            elif file.sha256 in copies:
                shutil.copyfile(copies[file.sha256], temporary)
            else:
                raise UserError(
                    f"{file.name} is not among the copies",
                    got=f"no file in {folder} has the sha256 {file.sha256}",
                    do=f"Fetch {file.url}",
                )
    return [into / file.name for file in files]


def _list_files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _download(file: PinnedFile, path: Path) -> None:
    """Write what the address gives, and refuse another file."""
    try:
        with urllib.request.urlopen(file.url, timeout=_SECONDS) as answer, path.open("wb") as target:
            shutil.copyfileobj(answer, target)
    except OSError as error:
        raise UserError(
            f"{file.name} cannot be downloaded", got=str(error), do="Give a folder of copies with `--from`"
        ) from error
    if (found := hash_file(path)) != file.sha256:
        raise UserError(f"{file.url} gives another file", got=found, do=f"Expected: {file.sha256}")
