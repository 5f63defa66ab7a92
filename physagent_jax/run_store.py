"""Reading and writing a run folder: one run per folder, resumable, never half-written."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import check_writable, write_text
from physagent_jax.run_folder import Manifest

Schema = TypeVar("Schema", bound=BaseModel)
PROBE = "probe"  # folder of the coarse rounds
_LAST_FILE = "judgement.json"  # written last, so an iteration that has it is complete


class RunStore:
    """A run folder.

    Args:
        path: The folder.
        manifest: The run's passport; two runs are the same if their ``inputs`` are equal.
    """

    def __init__(self, path: Path, manifest: Manifest):
        self.path, self.manifest = path, manifest

    @staticmethod
    def open(path: str | Path, manifest: Manifest, *, overwrite: bool = False) -> RunStore:
        """A store for a new run, or for the one that was stopped in ``path``. Nothing is written yet.

        Raises:
            UserError: The folder holds another run, or something else, or cannot be written.
        """
        path = Path(path)
        if overwrite and (path / "manifest.json").is_file():
            shutil.rmtree(path)
        earlier = _read(path / "manifest.json", Manifest)
        if earlier is not None and earlier.inputs != manifest.inputs:
            raise UserError(
                f"{path} holds another run ({earlier.prompt!r}, or other settings)",
                do="Choose another --out, or pass --overwrite to replace it",
            )
        if earlier is not None:
            return RunStore(path, earlier)
        if path.is_file() or (path.is_dir() and any(path.iterdir())):
            raise UserError(f"{path} exists and is not a run folder", do="Choose another --out")
        check_writable(path)
        return RunStore(path, manifest)

    def update(self, **changes) -> None:
        """Changes the manifest and writes it."""
        self.manifest = self.manifest.model_copy(update=changes)
        self.write("manifest.json", self.manifest)

    def discard_if_barren(self) -> None:
        """Removes the folder if nothing was simulated in it: a refused run leaves nothing behind."""
        if not any((self.path / name).exists() for name in ("iterations", PROBE)):
            shutil.rmtree(self.path, ignore_errors=True)

    def part(self, name: str) -> RunStore:
        """A folder within this one that holds iterations of its own."""
        return RunStore(self.path / name, self.manifest)

    def iteration(self, index: int) -> Path:
        """Folder of an iteration."""
        return self.path / "iterations" / str(index)

    def completed_iterations(self) -> int:
        """How many iterations, counted from 0, are complete."""
        count = 0
        while (self.iteration(count) / _LAST_FILE).is_file():
            count += 1
        return count

    def write(self, name: str, value: BaseModel) -> None:
        """Writes a schema as JSON, atomically; ``name`` is relative to the run folder."""
        text = json.dumps(value.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"
        write_text(self.path / name, text)

    def read(self, name: str, schema: type[Schema]) -> Schema | None:
        """Reads a schema, None if the file is absent.

        Raises:
            UserError: The file is not valid.
        """
        return _read(self.path / name, schema)


def _read(path: Path, schema: type[Schema]) -> Schema | None:
    try:
        return schema.model_validate_json(path.read_bytes())
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValidationError) as error:
        first = str(error).splitlines()[0]
        raise UserError(
            f"{path} cannot be read",
            got=first,
            do="Pass --overwrite to start afresh, or choose another --out",
        ) from None
