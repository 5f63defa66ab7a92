"""The objects that tasks are about: made on the spot, bundled, and, with a folder of data, captured ones.

None looks at a method: stiffness and density are so that a clip costs little and nothing tears under the library's
forces.
"""

from __future__ import annotations

import dataclasses
import hashlib
from pathlib import Path
from typing import Any

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.procedural import PROCEDURAL

_HERE = Path(__file__).resolve().parent
_BUNDLED = _HERE / "assets"  # of an installed package; a checkout has them where examples use them
_EXAMPLES = _BUNDLED if _BUNDLED.is_dir() else _HERE.parent / "examples" / "assets"
_GAUSSIANS = 2500


@dataclasses.dataclass(frozen=True)
class TaskObject:
    """An object of 1 m.

    Attributes:
        kind: Class with a physical prior.
        up: The file's up axis; None = told from the file.
        youngs_modulus: [Pa].
        poissons_ratio: nu.
        file: Bundled file; None = none is.
        data: Name of its file in the folder of data; None = it needs none. With neither, it is made.
        digest: SHA-256 of its file, with which it has to agree; "" = it is made.
        captured: "3DGS" or "scan": where it is from; None = it is made.
        cells: Along a side of the domain of 4 m: two to a thin part.
        particles: At most; some three in a cell of full matter, or it tears where it should stretch.
    """

    kind: str
    up: str | None = "+z"
    youngs_modulus: float = 3e4
    poissons_ratio: float = 0.3
    file: Path | None = None
    data: str | None = None
    digest: str = ""
    captured: str | None = None
    cells: int = 48
    particles: int = 1500

    @property
    def material(self) -> dict[str, Any]:
        """For `pa.build_scene`."""
        return dict(youngs_modulus=self.youngs_modulus, poissons_ratio=self.poissons_ratio, density=DENSITY)


DENSITY = 400.0  # [kg/m^3]
OBJECTS = {
    "jelly": TaskObject("jelly", youngs_modulus=2e4, cells=40),
    "loaf": TaskObject("food"),
    "plant": TaskObject("plant", youngs_modulus=6e4, cells=64),
    "robot": TaskObject(
        "robot",
        up="-y",
        youngs_modulus=8e4,
        cells=64,
        file=_EXAMPLES / "robot.ply",
        digest="4626a22d836bcdc563782b89d4b62bc1bcdb691908b7ce47ca5ec2fd086ddd34",
        captured="3DGS",
    ),
    "guitar": TaskObject(
        "instrument",
        up="-y",
        youngs_modulus=1e5,
        cells=64,
        data="guitar_sh0.ply",
        digest="36ae11b4cae394bb2659dbc471bf5a717a79df48376edc763cdf1ad4755f8588",
        captured="3DGS",
    ),
    "bunny": TaskObject(
        "animal",
        up="+y",
        data="bunny.obj",
        digest="d97f4aa37c2f3bfb14eceb3d06ac1f466062dc45f08e019bfbae9704c28654b6",
        captured="scan",
        particles=2000,
    ),
}


def add_object(text: str) -> str:
    """Make an object of one's own known for this process, and return its name.

    Args:
        text: ``NAME=FILE``, and fields of `TaskObject` behind it: ``vase=vase.ply,kind=vessel,up=-y``. The default kind
            is the name, the default side up is told from the file.

    Raises:
        UserError: The text is not of that form, the name is taken, or there is no such file or field.
    """
    name, equals, rest = text.partition("=")
    place, *pairs = rest.split(",")
    if not (name and equals and place):
        raise UserError("an object of one's own is NAME=FILE", got=text, do="For example vase=vase.ply,up=+y")
    path = Path(place)
    if not path.is_file():
        raise UserError(f"there is no file of the object `{name}`", got=place)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    if name in OBJECTS and OBJECTS[name].digest != digest:
        raise UserError("there is another object of this name", got=name, do="Choose another name")
    known = {"kind": str, "up": str, "youngs_modulus": float, "poissons_ratio": float}
    known |= {"cells": int, "particles": int}
    fields: dict[str, Any] = {"kind": name, "up": None}
    for pair in pairs:
        field, _, value = pair.partition("=")
        try:
            fields[field] = known[field](value)
        except (KeyError, ValueError):
            raise UserError(
                f"the object `{name}` has no such field or value", got=pair, do=f"Fields: {', '.join(known)}"
            ) from None
    OBJECTS[name] = TaskObject(**fields, file=path.resolve(), digest=digest)
    return name


def is_available(name: str, data: Path | None) -> bool:
    """Return whether an object can be had with this folder of data.

    Raises:
        UserError: There is no such object.
    """
    if name not in OBJECTS:
        raise explain_unknown_name("object", name, OBJECTS)
    needed = OBJECTS[name].data
    return needed is None or (data is not None and (data / needed).is_file())


def find_file(name: str, folder: Path, data: Path | None) -> Path:
    """An object's file, made in ``folder`` if it has to be.

    Raises:
        UserError: It is in a folder of data that is not given, or not there, or another file has its name.
    """
    thing = OBJECTS.get(name)
    if not is_available(name, data) or thing is None:
        needed = OBJECTS[name].data
        raise UserError(
            f"the object `{name}` needs the file {needed}",
            got=data,
            do="Give the folder of data that holds it",
        )
    if thing.file is not None:
        return _check_file(name, thing.file)
    if thing.data is not None and data is not None:
        return _check_file(name, data / thing.data)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.ply"
    if not path.is_file():
        write_ply(path, PROCEDURAL[name](0, count=_GAUSSIANS))
    return path


def _check_file(name: str, path: Path) -> Path:
    """The file, if it is the one that tasks were made with."""
    if hashlib.sha256(path.read_bytes()).hexdigest() != OBJECTS[name].digest:
        raise UserError(
            f"the file of the object `{name}` is not the one that its tasks were made with",
            got=path,
            do=f"Take the file with the SHA-256 {OBJECTS[name].digest}",
        )
    return path
