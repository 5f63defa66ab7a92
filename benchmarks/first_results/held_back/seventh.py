"""Pairs on a seventh lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: a language model wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.fourth import NEEDLE, STATUES
from benchmarks.first_results.pins import PinnedFile

RESTAURANT = (
    "KayKit-Game-Assets/KayKit-Restaurant-Bits-1.0/153c8a7535b48237854cb54ff6890679f8c574d1"
    "/addons/kaykit_restaurant_bits/Assets/obj"
)

FILES: Mapping[str, PinnedFile] = {
    "dragon": PinnedFile(
        "Dragon.glb",
        f"{NEEDLE}/AnimatedProperties/Models",
        "56c46dad52b0229993548e86664f6d334226dffde0f4d8bd0f4dc25845214161",
        "mesh, Needle Engine samples, of the Stanford dragon (research use, with credit)",
    ),
    "stool": PinnedFile(
        "chair_stool.obj",
        RESTAURANT,
        "2c348ffe113993e0c9b6875d754af989c51d70ce7308bc6bd944bb893abdfb65",
        "mesh, KayKit Restaurant Bits, CC0",
    ),
    "knight": PinnedFile(
        "knight.glb",
        f"{NEEDLE}/MaterialXNodes/Models",
        "c5c1d9e530bf070789135634a7bdee0e0d19c0c4f574a394cacc37eec32bd9d3",
        "mesh, Needle Engine samples; the repository's licence is MIT",
    ),
    "vase": PinnedFile(
        "Vase.glb",
        f"{NEEDLE}/Transmission/Content/Models",
        "58dee0e741c7cdfd3e1615cbc00b7969a8b21329998ecd7ffa113396e5a16f31",
        "mesh, Needle Engine samples; the repository's licence is MIT",
    ),
    "sage": PinnedFile(
        "massa.sog",
        STATUES,
        "d60f8a4da99349847aeb59a284320f7fd6960bb7db6d6d7dc803dc09111b5050",
        "3DGS capture, PlayCanvas web components examples; the repository's licence is MIT",
    ),
}

_OPTIONS = {
    "stool": ("--up", "+y"),
    "sage": ("--up", "-y"),
}  # the files do not tell; pictures show each upright

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("dragon", "Pull the dragon's tail to the right", "part stretch"),
    Case("dragon", "The dragon is made of jelly and wobbles", "material sway"),
    Case("dragon", "The dragon jumps up and then falls over on its side", "sequence jump tip"),
    Case("dragon", "Spin the dragon around twice", "spin quantity"),
    Case("stool", "Twist the seat of the stool to the left", "part twist"),
    Case("stool", "Slowly squash the stool flat from above", "squeeze"),
    Case("stool", "Tip the stool over and then roll it across the floor", "sequence tip roll"),
    Case("stool", "Drop a rubber stool so it bounces", "material drop"),
    Case("knight", "Bend the horse's head backwards", "part bend"),
    Case("knight", "Knock the chess piece over", "hit tip"),
    Case("knight", "Tilt the knight 30 degrees to the left", "tip quantity"),
    Case("knight", "Lift the knight up and then drop it", "sequence lift drop"),
    Case("vase", "Gently push the vase so it rocks a little", "push sway slight"),
    Case("vase", "The vase is soft clay and someone squeezes its neck", "material part squeeze"),
    Case("vase", "Drop the vase from one meter high", "drop quantity"),
    Case("vase", "Throw the vase up into the air", "throw"),
    Case("sage", "The statue is suddenly hit from the left", "hit violent"),
    Case("sage", "Pull the old man's beard forward", "part stretch"),
    Case("sage", "The statue shakes in an earthquake and then stands still", "sequence sway stillness"),
    Case("sage", "A foam statue sways back and forth in the wind", "material sway wind"),
)

SETS = {"seventh": _PAIRS}
