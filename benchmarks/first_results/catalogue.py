"""The sentences, written before any of them was tried; none is taken out because it fails.

Those of `FIRST` have been run many times and developed with; the other sets are in
`benchmarks.first_results.held_back`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import trimesh

from benchmarks.first_results import held_back
from benchmarks.first_results.cases import Case, Thing
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.presets import PresetName
from physagent_jax.scene.procedural import PROCEDURAL

PAPER = PresetName.PAPER
KINDS = frozenset(
    "push hit spin drop throw stretch squeeze twist sway bend wind lift sequence stillness part slight violent "
    "quantity space wall material jump tip roll".split()
)


def _procedural(name: str) -> Thing:
    def make(path: Path) -> None:
        write_ply(path, PROCEDURAL[name](0))

    return Thing("procedural, of this project", f"{name}.ply", make, ("--up", "+z"))


THINGS = {
    "robot": Thing('3DGS, "PLAYBOT" by Stéphane Agullo (sa3d.fr), CC-BY-4.0, cropped; bundled', "robot.ply"),
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
    **held_back.THINGS,
}

FIRST = (
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


SETS: Mapping[str, tuple[Case, ...]] = {"sentences": FIRST, **held_back.SETS}


def name_case(number: int, case: Case, group: str = "sentences") -> str:
    """Its name in files, of its number counted from 1 in its set."""
    return f"{'' if group == 'sentences' else f'{group}-'}{number:02d}-{case.thing}"


def name_cases(group: str) -> dict[str, Case]:
    """The sentences of a set by their names."""
    return {name_case(number, case, group): case for number, case in enumerate(SETS[group], 1)}
