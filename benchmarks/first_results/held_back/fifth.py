"""Pairs on a fifth lot of objects that nothing was developed with, written before any was run, and never changed."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.fourth import LIBIGL, NEEDLE, STATUES
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "camel": PinnedFile(
        "camel_b.obj",
        LIBIGL,
        "91f7a9a22a273e3dc4c9eab85674ac2a04355f21699a18032f2d5f1f7a7f62c4",
        "mesh, libigl tutorial data; no licence is stated",
    ),
    "windmill": PinnedFile(
        "Windmill.glb",
        f"{NEEDLE}/ShootingRange/Content/Target/Models",
        "53b1392297c2fc2469b53317960cbae28e58760fb79a9ce6fe02fd146a0c19ca",
        "mesh with texture, Needle Engine samples; the repository's licence is MIT",
    ),
    "houseplant": PinnedFile(
        "Plant_2.glb",
        f"{NEEDLE}/Configurator/Content/Plants/Plant_2/Models",
        "990efb395a0232da9102710a51535810e9026353583d1e654e1a41e8642dfffd",
        "mesh with texture, Needle Engine samples; the repository's licence is MIT",
    ),
    "jeep": PinnedFile(
        "Jeep.glb",
        f"{NEEDLE}/CarPhysics/Content/Jeep",
        "198034c654f8eb5533b9d98ebc665fd188a6ba775c6944999c57c3b30b721180",
        "mesh with texture, Needle Engine samples; the repository's licence is MIT",
    ),
    "saint": PinnedFile(
        "st-peter.sog",
        STATUES,
        "b7821fe01fee6acca1452212864d4170e612a7941875f46fad85fe03612c3b3d",
        "3DGS capture, PlayCanvas web components examples; the repository's licence is MIT",
    ),
}

_OPTIONS = {
    "camel": ("--up", "+y"),
    "saint": ("--up", "-y"),
}  # the files do not tell; pictures show each upright

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("camel", "press the camel's hump down until it is nearly flat", "squeeze part"),
    Case("camel", "slowly bend the camel's neck down as if it were drinking", "bend part slight"),
    Case("camel", "a camel made of soft dough sags until its belly touches the ground", "material part"),
    Case("camel", "throw the camel forward so it tumbles head over heels once", "throw spin quantity"),
    Case("windmill", "the wind makes the windmill's big wheel turn", "wind spin part"),
    Case("windmill", "yank the windmill's tail vane hard to the left", "push part violent"),
    Case(
        "windmill",
        "the wooden tower of the windmill sways back and forth in a gale",
        "sway wind material part",
    ),
    Case("windmill", "tilt the windmill 30 degrees backwards and then let it fall", "tip quantity sequence"),
    Case(
        "houseplant",
        "pull the tallest leaf of the plant down and let it spring up again",
        "bend part sequence",
    ),
    Case("houseplant", "push the flowerpot slowly along the ground to the right", "push part slight"),
    Case("houseplant", "drop the plant upside down onto its leaves", "drop part"),
    Case("houseplant", "spin the potted plant so fast that its leaves fly outwards", "spin part violent"),
    Case("jeep", "press the hood of the jeep down hard and let go", "squeeze part violent sequence"),
    Case("jeep", "the jeep rolls over sideways once and ends up on its wheels", "spin tip quantity sequence"),
    Case("jeep", "lift the jeep's front bumper until the jeep stands on its back end", "lift tip part"),
    Case("jeep", "an iron jeep plunges nose first onto the ground", "drop material"),
    Case("saint", "the saint and his pedestal suddenly topple over backwards", "tip violent"),
    Case("saint", "twist the saint's head a quarter turn to the right", "twist part quantity"),
    Case("saint", "bend a rubber saint forward until his face is over his book", "bend material part"),
    Case("saint", "push the pedestal gently to the left and then back again", "push part slight sequence"),
)

SETS = {"fifth": _PAIRS}
