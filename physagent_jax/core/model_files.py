"""Places where the files of models are looked for. Nothing is downloaded here, and nothing heavy is imported."""

from __future__ import annotations

import os
import re
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten

_IDENTIFIER = re.compile(r"[A-Za-z0-9][\w.-]*/[A-Za-z0-9][\w.-]*")


def find_models_folder() -> Path:
    """The folder of files that no hub keeps: ``PHYSAGENT_MODELS``, else ``models`` in this package's cache."""
    if chosen := os.environ.get("PHYSAGENT_MODELS"):
        return Path(chosen).expanduser()
    return _find_caches() / "physagent_jax" / "models"


def find_hub_cache() -> Path:
    """The folder in which Hugging Face's tools keep what they have downloaded, by their own variables."""
    if chosen := os.environ.get("HF_HUB_CACHE"):
        return Path(chosen).expanduser()
    home = os.environ.get("HF_HOME")
    return (Path(home).expanduser() if home else _find_caches() / "huggingface") / "hub"


def find_snapshot(identifier: str, *files: str) -> Path | None:
    """The newest snapshot of a hub's repository in the cache that holds ``files``; None if there is none.

    Args:
        identifier: "owner/name".
        files: Names of files that must be there.
    """
    snapshots = find_hub_cache() / f"models--{identifier.replace('/', '--')}" / "snapshots"
    complete = [
        each
        for each in snapshots.glob("*")
        if all((each / name).is_file() for name in files or ("config.json",))
    ]
    return max(complete, key=lambda each: each.stat().st_mtime, default=None)


def is_identifier(weights: str) -> bool:
    """Return whether a text is the name of a hub's repository, "owner/name", rather than a path that exists."""
    return _IDENTIFIER.fullmatch(weights) is not None and not Path(weights).exists()


def locate_folder(weights: object, what: str, *, download: bool = False) -> str:
    """The folder of a model's files, or the hub's name for it where it may be downloaded.

    Args:
        weights: A folder with config.json, or "owner/name".
        what: The model, for messages ("`sam2`").
        download: Whether files that are missing may be fetched by the hub's own client.

    Raises:
        UserError: There is no such folder, or the repository is not in the cache and may not be downloaded.
    """
    if not isinstance(weights, str) or not weights:
        raise UserError(f"`weights` of {what} must be a folder or owner/name", got=shorten(repr(weights)))
    if not is_identifier(weights):
        folder = Path(weights).expanduser()
        if not (folder / "config.json").is_file():
            raise UserError(
                f"there is no model for {what} in this folder",
                got=shorten(folder),
                do="Name the one with config.json",
            )
        return str(folder)
    if download:
        return weights
    if (found := find_snapshot(weights)) is None:
        raise UserError(
            f"the weights of {what} are not on this machine",
            got=f"{weights}, looked for in {find_hub_cache()}",
            do=f"`hf download {weights}` fetches them, and so does the option `download` = true; `physagent models` "
            "tells their licence",
        )
    return str(found)


def _find_caches() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
