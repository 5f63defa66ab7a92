"""Pairs on a twenty-third lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "ferriswheel": PinnedFile(
        "ferris-wheel.gltf",
        f"{MARKET}/ferris-wheel",
        "7b523a93ff94284ebc01ce09174341c274ad76afc9e4b8dc59ef691215b76001",
        "mesh, by creativetrio, CC0-1.0",
        "model.gltf",
    ),
    "grapes": PinnedFile(
        "grapes.gltf",
        f"{MARKET}/grapes",
        "54ab920c7773eae0582ecb1fa2d6d16e43c79d3c7697dd0304e4538f51df8517",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "console": PinnedFile(
        "nes.gltf",
        f"{MARKET}/nes",
        "a43e906e4df2ca9c97c6cbec5054dac5ad8da8ab41cca7dde388af2e0632a948",
        "mesh, by Lightbringer3D, CC0-1.0",
        "model.gltf",
    ),
    "knifeblock": PinnedFile(
        "knife-block.gltf",
        f"{MARKET}/knife-block",
        "bc2ff34c50c6f34d5d4cf3c91f456b85963b68547d23ada92da9a601d9b87997",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "smalltree": PinnedFile(
        "tree-small.gltf",
        f"{MARKET}/tree-small",
        "249a17d0bfbe62375019d46e99fa17cb40a4e3c00d3cbabc630892603fc4abc4",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case(
        "ferriswheel",
        "Make the big wheel turn slowly between its legs while the legs stay put on the ground.",
        "spin part slight stillness",
    ),
    Case(
        "ferriswheel",
        "a strong gust of wind knocks the ferris wheel over sideways",
        "hit tip wind",
    ),
    Case(
        "ferriswheel",
        "Someone lifts the whole ferris wheel up into the air, holds it there for a second, then lets go so "
        "it crashes down onto the floor and breaks apart.",
        "drop lift sequence violent",
    ),
    Case(
        "ferriswheel",
        "melt it into a puddle",
        "squeeze",
    ),
    Case(
        "grapes",
        "squash the grapes flat",
        "squeeze",
    ),
    Case(
        "grapes",
        "The bunch tips over onto its side and then rolls a little way across the floor before it stops.",
        "tip roll sequence",
    ),
    Case(
        "grapes",
        "Can you make the leaves on top flap up and down like there's a gust of wind, while the rest of it "
        "stays put?",
        "sway wind part stillness",
    ),
    Case(
        "grapes",
        "These grapes are made of jelly. Drop them from about a metre up so they bounce once and then wobble "
        "until they settle.",
        "material drop jump sway sequence",
    ),
    Case(
        "console",
        "drop it from about head height and let it bounce",
        "drop jump",
    ),
    Case(
        "console",
        "The NES is made of soft jelly, and someone presses down hard on it from above and then lets go so "
        "it wobbles back into shape.",
        "material sway squeeze sequence",
    ),
    Case(
        "console",
        "The light gray top half of the console gets pulled off and falls on the floor beside the dark "
        "bottom half.",
        "drop stretch part",
    ),
    Case(
        "console",
        "Give the console a good shove so it slides across the floor, then tip it over onto its side.",
        "push tip sequence",
    ),
    Case(
        "knifeblock",
        "knock it over onto its side",
        "hit tip",
    ),
    Case(
        "knifeblock",
        "Pull the middle knife out of the block by its handle and let it drop on the floor.",
        "drop stretch part sequence",
    ),
    Case(
        "knifeblock",
        "The whole thing is made of soft rubber, so when it's dropped from about a metre up it should bounce "
        "a couple of times and wobble before it settles.",
        "material drop jump sway",
    ),
    Case(
        "knifeblock",
        "Give it a hard shove so it slides across the floor, then lift it up in the air and set it back down "
        "upside down",
        "push spin lift sequence",
    ),
    Case(
        "smalltree",
        "A strong gust of wind bends the tree over to the right, then it dies down and the tree sways back "
        "upright.",
        "sway bend wind sequence",
    ),
    Case(
        "smalltree",
        "knock it over",
        "hit tip",
    ),
    Case(
        "smalltree",
        "The tree is made of jelly and someone drops it from about a metre up, so it squashes when it lands "
        "and wobbles for a bit.",
        "material drop sway squeeze",
    ),
    Case(
        "smalltree",
        "Snap the trunk so the green top tips off and falls to the ground",
        "drop tip part",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentythird": _PAIRS}
