"""The sentences, written before any of them was tried; none is taken out because it fails."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import trimesh

from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.presets import PresetName
from physagent_jax.scene.procedural import PROCEDURAL

ROBOT = Path(__file__).resolve().parents[2] / "examples" / "assets" / "robot.ply"
PAPER = PresetName.PAPER
KINDS = frozenset(
    "push hit spin drop throw stretch squeeze twist sway bend wind lift sequence stillness part slight violent "
    "quantity space wall".split()
)


@dataclasses.dataclass(frozen=True)
class Thing:
    """An object.

    Attributes:
        credit: Where it is from, and its licence.
        file: Its name in the folder of data, or of what ``make`` writes.
        make: Writes it; None = it is in the folder of data.
        options: More options of the command line.
    """

    credit: str
    file: str = ""
    make: Callable[[Path], object] | None = None
    options: tuple[str, ...] = ()

    def find_file(self, data: Path | None, made: Path) -> Path | None:
        """The object's file, made below ``made`` if it has to be; None if ``data`` does not hold it."""
        if self.make is not None:
            made.mkdir(parents=True, exist_ok=True)
            self.make(made / self.file)
            return made / self.file
        for folder in (ROBOT.parent, data):
            if folder is not None and (folder / self.file).is_file():
                return folder / self.file
        return None


@dataclasses.dataclass(frozen=True)
class Case:
    """A sentence.

    Attributes:
        thing: Name of the object.
        sentence: As somebody would write it who has never used the product.
        kinds: What it is here for, of `KINDS`.
        preset: Resolution of the run.
        options: More of the command line: world, anchor.
    """

    thing: str
    sentence: str
    kinds: str
    preset: PresetName = PresetName.FAST
    options: tuple[str, ...] = ()


def _procedural(name: str) -> Thing:
    def make(path: Path) -> None:
        write_ply(path, PROCEDURAL[name](0))

    return Thing("procedural, of this project", f"{name}.ply", make, ("--up", "+z"))


THINGS = {
    "robot": Thing('3DGS, "PLAYBOT" by Stéphane Agullo (sa3d.fr), CC-BY-4.0, cropped; bundled', ROBOT.name),
    "guitar": Thing(
        "3DGS capture, 84,130 Gaussians, PlayCanvas engine examples, MIT",
        "guitar_sh0.ply",
        options=("--up", "-y"),
    ),
    "plant": _procedural("plant"),
    "jelly": _procedural("jelly"),
    "loaf": _procedural("loaf"),
    "cow": Thing("mesh, Spot by Keenan Crane, public domain", "spot.obj", options=("--up", "+y")),
    "bunny": Thing(
        "mesh, Stanford 3D Scanning Repository (research use, with credit)",
        "bunny.obj",
        options=("--up", "+y"),
    ),
    "ball": Thing(
        "mesh, a sphere of 1,280 triangles",
        "ball.obj",
        lambda path: trimesh.creation.icosphere(3, 0.5).export(path),
        ("--up", "+z"),
    ),
}

CASES = (
    Case("robot", "push the robot gently to the left", "push slight"),
    Case("robot", "a strong wind pushes the robot to the left", "push wind", PAPER),
    Case("robot", "rotate the robot by 90 degrees", "spin quantity"),
    Case("guitar", "drop the guitar", "drop"),
    Case("guitar", "someone hits the guitar hard from the left", "hit"),
    Case("guitar", "lift the guitar up and hold it there", "lift", PAPER),
    Case("plant", "a strong wind bends the plant to the left, then lets go", "bend wind", PAPER),
    Case("plant", "the plant sways gently in the breeze", "sway wind slight"),
    Case("plant", "hit the top of the plant from the right", "hit part"),
    Case("jelly", "the jelly wobbles and then comes to rest", "sway stillness"),
    Case("jelly", "squash the jelly to half its height", "squeeze quantity", PAPER),
    Case("jelly", "stretch the jelly sideways", "stretch"),
    Case("loaf", "squeeze the loaf from both sides", "squeeze"),
    Case("loaf", "twist the loaf of bread", "twist", PAPER),
    Case("loaf", "the loaf lies still and nothing moves", "stillness"),
    Case("cow", "push the cow to the right, then lift it up, then drop it", "push lift drop sequence"),
    Case("cow", "shake the cow violently", "sway violent"),
    Case("cow", "pull the cow's head to the left", "push part", PAPER),
    Case("bunny", "throw the bunny up into the air", "throw"),
    Case("bunny", "drop the bunny", "drop", PAPER),
    Case("bunny", "the bunny is floating in space and slowly spins", "spin space slight"),
    Case("ball", "throw the ball against the wall on the right", "throw wall"),
    Case("ball", "kick the ball hard to the left", "hit", PAPER),
    Case("ball", "roll the ball to the right", "push spin"),
)


def name_case(number: int, case: Case) -> str:
    """Its name in files, of its number counted from 1."""
    return f"{number:02d}-{case.thing}"
