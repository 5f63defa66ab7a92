"""Objects and sentences, as classes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

from benchmarks.first_results.pins import PinnedFile
from physagent_jax.core.errors import UserError
from physagent_jax.scene.presets import PresetName

BUNDLED = Path(__file__).resolve().parents[2] / "examples" / "assets"


@dataclasses.dataclass(frozen=True)
class Thing:
    """An object.

    Attributes:
        credit: Where it is from, and its licence.
        file: Its name in the folder of data, or of what ``make`` writes.
        make: Writes it; None = it is in the folder of data.
        options: More options of the command line.
        pinned: The only file that it may be; None = any of that name.
    """

    credit: str
    file: str = ""
    make: Callable[[Path], object] | None = None
    options: tuple[str, ...] = ()
    pinned: PinnedFile | None = None

    def find_file(self, data: Path | None, made: Path) -> Path | None:
        """The object's file, made below ``made`` if it has to be; None if ``data`` does not hold it.

        Raises:
            UserError: The file of that name is another one than was pinned.
        """
        if self.make is not None:
            made.mkdir(parents=True, exist_ok=True)
            self.make(made / self.file)
            return made / self.file
        for folder in (BUNDLED, data):
            if folder is not None and (folder / self.file).is_file():
                return self._check(folder / self.file)
        return None

    def _check(self, path: Path) -> Path:
        if self.pinned is not None and not self.pinned.is_in(path):
            raise UserError(
                f"{path} is another file than the sentences are about",
                do=f"Remove it, and fetch it by `python -m benchmarks.first_results.objects --into {path.parent}`",
            )
        return path


def pin_things(files: Mapping[str, PinnedFile], options: Mapping[str, tuple[str, ...]]) -> dict[str, Thing]:
    """The objects of pinned files, with the options of the command line that some of them need."""
    return {
        name: Thing(file.credit, file.name, options=options.get(name, ()), pinned=file)
        for name, file in files.items()
    }


@dataclasses.dataclass(frozen=True)
class Case:
    """A sentence.

    Attributes:
        thing: Name of the object.
        sentence: As somebody would write it who has never used the product.
        kinds: What it is here for, of `benchmarks.first_results.catalogue.KINDS`.
        preset: Resolution of the run.
        options: More of the command line: world, anchor.
    """

    thing: str
    sentence: str
    kinds: str
    preset: PresetName = PresetName.FAST
    options: tuple[str, ...] = ()
