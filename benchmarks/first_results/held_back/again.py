"""Pairs on five objects more that nothing was developed with, written before any was run, and never changed."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

BEVY = "bevyengine/bevy/4805ca792c3e94eef07afd6fa9a2712f388c9a67/assets/models"
WEB_COMPONENTS = "playcanvas/web-components"

FILES: Mapping[str, PinnedFile] = {
    "fox": PinnedFile(
        "Fox.glb",
        f"{BEVY}/animated",
        "d97044e701822bac5a62696459b27d7b375aada5de8574ed4362edbba94771f7",
        "glTF sample with texture, mesh by PixelMannen (CC0-1.0), rigged by tomkranis (CC-BY-4.0)",
    ),
    "alien": PinnedFile(
        "alien.glb",
        f"{BEVY}/AlienCake",
        "fc660db2b2efa44b9968c119959c9ff99ba3d32aff21e728938b6f3e064d587d",
        "mesh with colours, Space Kit by Kenney (kenney.nl), CC0-1.0",
    ),
    "robot-arm": PinnedFile(
        "robot-arm.glb",
        f"{WEB_COMPONENTS}/b24c63cd22cafb1c0245149f69b80361b31f0f00/examples/assets/models",
        "1d8a11ebcae49a0cb112709ec9870c7c360c4fe824aed56b81c05782662a7cec",
        "mesh, PlayCanvas web components examples; no licence is stated, the repository's is MIT",
    ),
    "cake": PinnedFile(
        "cakeBirthday.glb",
        f"{BEVY}/AlienCake",
        "64b6cd87fbb42a921b9cc8dfc1049c78ae2b9c9bed9f4dccfec375c488d029bf",
        "mesh with colours, Food Kit by Kenney (kenney.nl), CC0-1.0",
    ),
    "angel": PinnedFile(
        "angel.compressed.ply",
        f"{WEB_COMPONENTS}/65e4fd3155ff41d5500e2286e86bea76d230d994/examples/assets/splats",
        "1dc37d96f6319565e385da254d2fa72845f65d84c134335e886ef7c998b239ff",
        "3DGS capture, 71,377 Gaussians, PlayCanvas web components examples; the repository's licence is MIT",
    ),
}

_OPTIONS = {"angel": ("--up", "+y")}  # a PLY does not tell; a preview shows it upright

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("fox", "the fox swishes its tail from side to side", "sway part"),
    Case("fox", "push the fox's head down", "push part"),
    Case("fox", "roll the fox over onto its back", "roll"),
    Case("fox", "stretch the fox until it is twice as long", "stretch quantity"),
    Case("alien", "lift the alien's left arm", "lift part"),
    Case("alien", "the little alien jumps for joy", "jump"),
    Case("alien", "bend the alien's antennae backwards", "bend part"),
    Case("alien", "a wooden alien topples over onto its back", "tip material"),
    Case("robot-arm", "bend the gripper of the robot arm downwards", "bend part"),
    Case("robot-arm", "take hold of a rubber robot arm and twist it", "twist material"),
    Case("robot-arm", "spin the robot arm halfway around", "spin quantity"),
    Case("robot-arm", "slide the robot arm to the left, then lift it up", "push lift sequence"),
    Case("cake", "press the cake flat from above with a hand", "squeeze"),
    Case("cake", "a birthday cake made of jelly jiggles", "sway material"),
    Case("cake", "the candles on the cake lean to one side in the wind", "bend wind part"),
    Case("cake", "toss the cake to the right", "throw"),
    Case("angel", "the angel flaps its wings", "sway part"),
    Case("angel", "a stone angel drops to the ground", "drop material"),
    Case("angel", "tilt the angel a little to the left, then let it rock back", "tip sway slight sequence"),
    Case("angel", "hit the angel on the head", "hit part"),
)

SETS = {"again": _PAIRS}
