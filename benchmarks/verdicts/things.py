"""The objects that clips show: bundled, made on the spot, and, with a folder of data, captured ones."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import trimesh

from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.config import Domain, Filling, Material, SignedAxis, Source
from physagent_jax.scene.load import hash_file
from physagent_jax.scene.procedural import PROCEDURAL

ROBOT = Path(__file__).resolve().parents[2] / "examples" / "assets" / "robot.ply"
DOMAIN = Domain(size=8.0, cells=104)  # 13 cells per body length
FILLING = Filling(max_particles=3500)  # three in a cell of full matter, and nearly all things have as many
GAUSSIANS = 2500


@dataclasses.dataclass(frozen=True)
class Thing:
    """An object of 1 m.

    Attributes:
        noun: What sentences call it.
        kind: Class with a physical prior, as a run would be told.
        make: Writes its file, given a path without suffix, or finds it in the folder of data; returns the file.
        up: The file's up axis.
        azimuth: Where the camera stands [degrees].
        youngs_modulus: [Pa].
        poissons_ratio: nu.
        frail: Whether parts hang by a thread that a turn tears.
        rooted: Why its foot is held; None = it is free.
        data: Name of its file in the folder of data; None = it needs none.
    """

    noun: str
    kind: str
    make: Callable[[Path], Path] | None = None
    up: SignedAxis = "+z"
    azimuth: float = 0.0
    youngs_modulus: float = 7e4
    poissons_ratio: float = 0.3
    frail: bool = False
    rooted: str | None = None
    data: str | None = None

    def make_material(self, youngs_modulus: float | None = None) -> Material:
        """Stiff enough to bear its own weight with a strain of 1 to 2 %, or as stiff as is said [Pa]."""
        return Material(
            youngs_modulus=youngs_modulus or self.youngs_modulus,
            poissons_ratio=self.poissons_ratio,
            density=250.0,
        )


def _mesh(make: Callable[[], trimesh.Trimesh]) -> Callable[[Path], Path]:
    def write(path: Path) -> Path:
        file = path.with_suffix(".obj")
        make().export(file)
        return file

    return write


def _procedural(name: str) -> Callable[[Path], Path]:
    def write(path: Path) -> Path:
        file = path.with_suffix(".ply")
        write_ply(file, PROCEDURAL[name](0, count=GAUSSIANS))
        return file

    return write


def _bottle() -> trimesh.Trimesh:
    profile = [(0, 0), (0.2, 0), (0.21, 0.03), (0.21, 0.55), (0.1, 0.74), (0.09, 1.0), (0, 1.0)]
    return trimesh.creation.revolve(np.array(profile, float), sections=48)


THINGS = {
    thing.noun: thing
    for thing in (
        Thing("robot", "robot", lambda path: ROBOT, up="-y", frail=True),
        Thing(
            "plant",
            "plant",
            _procedural("plant"),
            youngs_modulus=3e5,
            rooted="plants are rooted: the pot or the foot of the stem does not move",
        ),
        Thing("loaf", "food", _procedural("loaf")),
        Thing(
            "jelly",
            "jelly",
            _procedural("jelly"),
            youngs_modulus=5e4,
            poissons_ratio=0.4,
        ),
        Thing(
            "crate",
            "object",
            _mesh(lambda: trimesh.creation.box((1, 0.7, 0.75))),
            azimuth=30.0,
        ),
        Thing("ball", "ball", _mesh(lambda: trimesh.creation.icosphere(3, 0.5))),
        Thing("board", "object", _mesh(lambda: trimesh.creation.box((0.6, 0.3, 1)))),
        Thing("bottle", "vessel", _mesh(_bottle)),
        Thing("guitar", "instrument", up="-y", data="guitar_sh0.ply"),
        Thing("cow", "animal", up="+y", azimuth=-60.0, data="spot.obj"),
        Thing("bunny", "animal", up="+y", data="bunny.obj"),
    )
}


def list_things(data: Path | None) -> list[str]:
    """Those that can be had with this folder of data."""
    return [name for name, thing in THINGS.items() if _has_file(thing, data)]


def _has_file(thing: Thing, data: Path | None) -> bool:
    return thing.data is None or (data is not None and (data / thing.data).is_file())


def find_source(thing: Thing, clips: Path, data: Path | None) -> Source:
    """The object's file, made below ``clips`` if it has to be."""
    if thing.data is not None:
        assert data is not None
        file = data / thing.data
    else:
        folder = clips / "objects"
        folder.mkdir(parents=True, exist_ok=True)
        file = _make_once(thing, folder)
    return Source(
        path=str(file.resolve()),
        sha256=hash_file(file),
        name=thing.noun,
        kind=thing.kind,
        up=thing.up,
        surface_samples=GAUSSIANS,
    )


def _make_once(thing: Thing, folder: Path) -> Path:
    """The object's file in ``folder``; several processes may ask for it at once."""
    assert thing.make is not None
    with tempfile.TemporaryDirectory(dir=folder) as mine:
        made = thing.make(Path(mine) / thing.noun)
        if Path(mine) not in made.parents:
            return made
        file = folder / made.name
        if not file.is_file():
            made.replace(file)
    return file


@cache
def load_body(name: str, clips: Path, data: Path | None) -> tuple[Source, Body]:
    """The object's file, and the object filled with particles."""
    source = find_source(THINGS[name], clips, data)
    return source, make_body(source, FILLING, DOMAIN, clips)
