"""Reading and writing a run folder: one run per folder, resumable, never half-written.

The manifest lists every file before it is written, and nothing else in the folder is ever touched (but for
`run.refused`, which is of no run in particular). A run that replaces
another one moves it aside (`run.previous`) when it has understood what it is asked for, and removes it when it is done.
"""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import find_leftovers, remove_leftovers, write_text
from physagent_jax.core.reading import read_model
from physagent_jax.run import previous
from physagent_jax.run.lock import FolderLock
from physagent_jax.run.manifest import FORMAT, Manifest
from physagent_jax.run.refused import REFUSED, RefusedReading, read_refused, replace_refused

Schema = TypeVar("Schema", bound=BaseModel)
PROBE = "probe"  # folder of the coarse rounds
REPORT = "report.html"  # the run's, whoever writes it
VIDEO = "video.mp4"  # for people: on a stage, with a camera of its own
PLAIN_VIDEO = "perception.mp4"  # the pictures that perception gets


class RunStore:
    """A run folder, held by this process until it is closed; made by `open`.

    Attributes:
        path: The folder, or a part of it that holds rounds of its own.
        manifest: What the run is and what it has written; two runs are the same if their ``inputs`` are equal.
    """

    def __init__(
        self,
        path: Path,
        manifest: Manifest,
        lock: FolderLock | None = None,
        replaced: Manifest | None = None,
        whole: RunStore | None = None,
    ):
        self.path, self._manifest = path, manifest
        self._lock, self._replaced, self._whole = lock, replaced, whole

    @staticmethod
    def open(
        path: str | Path, manifest: Manifest, *, overwrite: bool = False, needed: Iterable[Path] = ()
    ) -> RunStore:
        """A store for a new run, or for the one that was stopped in ``path``. Nothing is written yet.

        Args:
            path: The folder.
            manifest: Manifest of the run that is asked for.
            overwrite: Whether it may replace another run. One that was stopped and is the same goes on.
            needed: Files that the run reads; it does not replace these.

        Raises:
            UserError: Another process writes there; or the folder holds another run, or something else, or
                cannot be written.
        """
        path = Path(path)
        lock = FolderLock(path)
        try:
            earlier = _recover(path)
            if earlier and overwrite and not earlier.complete and earlier.inputs != manifest.inputs:
                earlier = _give_way(path, earlier)
            if earlier is None:
                begun = [path / "manifest.json", path / REFUSED]  # by processes that were killed
                if set(path.iterdir()) - {path / REFUSED, *itertools.chain(*map(find_leftovers, begun))}:
                    raise UserError(f"{path} exists and is not a run folder", do="Choose another --out")
                for name in begun:
                    remove_leftovers(name)
                return RunStore(path, manifest, lock)
            if earlier.inputs == manifest.inputs and not (overwrite and earlier.complete):
                return RunStore(path, earlier, lock)
            if not overwrite:
                raise _make_other_run_error(path, earlier)
            _check_needed(path, earlier, needed)
            return RunStore(path, manifest, lock, replaced=earlier)
        except BaseException:
            lock.release()
            raise

    @property
    def manifest(self) -> Manifest:
        """The run's manifest."""
        return self._whole.manifest if self._whole else self._manifest

    def __enter__(self) -> RunStore:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        """Let other processes have the folder."""
        if self._lock is not None:
            self._lock.release()

    def begin(self) -> None:
        """Make the folder this run's: what it replaces is moved aside, and the manifest is written."""
        if self._replaced is not None:
            previous.move_aside(self.path, self._replaced.files)
            self._replaced = None
        self.claim("manifest.json", REPORT)

    def finish(self, **changes) -> None:
        """Marks the run complete, with ``changes`` to the manifest, and removes what it has replaced."""
        self.update(**changes, complete=True)
        _recover(self.path)

    def discard_if_barren(self) -> bool:
        """Remove what the run has written if it has simulated nothing: what it was to replace stands again.

        Calls of agents that failed are no less worth keeping: they are paid for.

        Returns:
            Whether that was so.
        """
        kept = any("iterations/" in name for name in self.manifest.files)
        kept |= any(cost.failed_calls for cost in self.manifest.agents)
        barren = self._replaced is None and not kept
        if barren:
            _give_way(self.path, self.manifest)
        return barren

    def find_refused(self) -> RefusedReading | None:
        """The reading of this very run, if it was refused before.

        Raises:
            UserError: The file of refused readings is not valid.
        """
        return next((each for each in read_refused(self.path) if each.inputs == self.manifest.inputs), None)

    def keep_refused(self, reading: RefusedReading) -> None:
        """Keep the reading of this run, which is refused; the folder goes to nobody by that."""
        replace_refused(self.path, self.manifest.inputs, reading)

    def drop_refused(self) -> None:
        """Take the reading of this run away, which has begun now and hold it itself."""
        replace_refused(self.path, self.manifest.inputs, None)

    def update(self, **changes) -> None:
        """Change the manifest and write it."""
        self._manifest = self._manifest.model_copy(update=changes)
        write_text(self.path / "manifest.json", _dump_json(self._manifest))

    def claim(self, *names: str) -> None:
        """List files that are about to be written; ``names`` are relative to `path`.

        Raises:
            UserError: Such a file is there already and is not this run's.
        """
        if self._whole:
            self._whole.claim(*(f"{self.path.name}/{name}" for name in names))
            return
        new = sorted(set(names) - set(self._manifest.files))
        for name in new:
            if os.path.lexists(self.path / name):
                raise UserError(
                    f"{self.path / name} is not this run's, and would be written over",
                    do="Move it out of the run folder, or choose another --out",
                )
        if new:
            self.update(files=tuple(sorted({*self._manifest.files, *new})))

    def claimed(self, name: str) -> Path:
        """The place of a file that is about to be written."""
        self.claim(name)
        return self.path / name

    def part(self, name: str) -> RunStore:
        """A folder within this one that holds rounds of its own."""
        return RunStore(self.path / name, self._manifest, whole=self)

    def round_folder(self, index: int) -> Path:
        """Folder of a round, counted from 0."""
        return self.path / "iterations" / str(index)

    def write(self, name: str, value: BaseModel) -> None:
        """Write a schema as JSON, atomically; ``name`` is relative to the run folder."""
        write_text(self.claimed(name), _dump_json(value))

    def read(self, name: str, schema: type[Schema]) -> Schema | None:
        """Read a schema; None if this run has not written it.

        Raises:
            UserError: The file is not valid.
        """
        return None if self._replaced else _read(self.path / name, schema)


def _recover(path: Path) -> Manifest | None:
    """The manifest of the run in ``path``, after finishing or undoing a replacement that was cut short."""
    try:
        earlier = _read(path / "manifest.json", Manifest)
    except UserError as error:
        what = f"{path} exists and is not a run folder, or its manifest is damaged"
        raise UserError(what, got=error.got, do="Choose another --out") from None
    if earlier is not None and earlier.format != FORMAT:
        raise UserError(
            f"{path} holds a run of another version",
            got=f"format {earlier.format}, this one writes {FORMAT}",
            do="Choose another --out, or remove the folder",
        )
    if earlier is not None:
        for name in earlier.files:
            remove_leftovers(path / name)
    if previous.exists(path):
        replaced = _read(previous.find_manifest(path), Manifest)
        assert replaced is not None
        if earlier is None:
            previous.restore(path, replaced.files)
            return replaced
        if earlier.complete:
            previous.drop(path, replaced.files)
    return earlier


def _give_way(path: Path, unfinished: Manifest) -> Manifest | None:
    """Remove an unfinished run; return the one that it was to replace, which stands again, if there is one."""
    previous.remove(path, unfinished.files)
    return _recover(path)


def _make_other_run_error(path: Path, earlier: Manifest) -> UserError:
    what = f"{path} holds another run ({earlier.prompt!r}, or other settings)"
    if previous.exists(path):
        replaced = _read(previous.find_manifest(path), Manifest)
        assert replaced is not None
        return UserError(
            what,
            got=f"it was stopped before it had replaced the run of {replaced.prompt!r}",
            do="Repeat its command to finish it, or pass --overwrite to drop it: the earlier run stands again until "
            "the new one is complete",
        )
    return UserError(what, do="Choose another --out, or pass --overwrite to replace it")


def _check_needed(path: Path, earlier: Manifest, needed: Iterable[Path]) -> None:
    owned = {(path / name).resolve() for name in earlier.files}
    for file in needed:
        if file.resolve() in owned:
            raise UserError(
                f"{file} belongs to the run that would be replaced, and is needed for the new one",
                do="Copy it out of the run folder, or choose another --out",
            )


def _dump_json(value: BaseModel) -> str:
    return json.dumps(value.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"


def _read(path: Path, schema: type[Schema]) -> Schema | None:
    if not os.path.lexists(path):
        return None
    try:
        return read_model(path, schema)
    except UserError as error:
        raise UserError(
            error.what, got=error.got, do="Choose another --out, or remove what is there"
        ) from None
