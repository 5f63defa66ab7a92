"""Pairs on a twentieth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "greendemon": PinnedFile(
        "GreenDemon.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "8087967cc972c2246c7d918c5f0af0fa102262d1dd9e2123fcc8ec6cc863ce3d",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "ponymare": PinnedFile(
        "low-poly-horse.gltf",
        f"{MARKET}/low-poly-horse",
        "1cf488c4867c5067b7ed5b0d9b4ac8921f8a2e84049f2a6e493ada81c7fa0fc9",
        "mesh, by MarkLaBarr, CC0-1.0",
        "model.gltf",
    ),
    "sportscar": PinnedFile(
        "sports-sedan.gltf",
        f"{MARKET}/sports-sedan",
        "a182afd95a1db984326c15298a674340d8d60e6446f5310f856f2d3fe89963f7",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "winebottle": PinnedFile(
        "wine-red.gltf",
        f"{MARKET}/wine-red",
        "acff927f4f641159e54cda67cea3ae1875aa765d157dc4d190e796315a129f03",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "parkbench": PinnedFile(
        "bench.gltf",
        f"{MARKET}/bench",
        "14ea0a580cd49a516dceeda0b6f9f352b498c98ee9c3ace1549a63b593526980",
        "mesh, by Sara Vieira, CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"greendemon": ("--up", "+y")})

_PAIRS = (
    Case(
        "greendemon",
        "make the monster hop up and down",
        "jump",
    ),
    Case(
        "greendemon",
        "Someone grabs the little monster by one of its horns, pulls it to the side and lets go.",
        "part",
    ),
    Case(
        "greendemon",
        "The monster is made of jelly and gets dropped on the floor, where it squashes flat and "
        "jiggles back into shape.",
        "material drop sway",
    ),
    Case(
        "greendemon",
        "Give it a hard shove from the front so it tips over and rolls onto its back",
        "push tip roll",
    ),
    Case(
        "ponymare",
        "The horse swishes its tail from side to side",
        "part sway",
    ),
    Case(
        "ponymare",
        "make the horse jump",
        "jump",
    ),
    Case(
        "ponymare",
        "The horse gets pushed hard from the side, tips over and falls onto the floor.",
        "push tip sequence",
    ),
    Case(
        "ponymare",
        "Drop it from about two meters up and let it bounce a couple of times",
        "drop quantity",
    ),
    Case(
        "sportscar",
        "The car drives forward fast and then skids to a stop",
        "push sequence",
    ),
    Case(
        "sportscar",
        "make the car out of jelly and drop it on the floor so it jiggles",
        "material drop sway",
    ),
    Case(
        "sportscar",
        "Flip the car over onto its roof.",
        "tip roll",
    ),
    Case(
        "sportscar",
        "Something heavy smashes into the front bumper and it crumples in.",
        "part hit",
    ),
    Case(
        "winebottle",
        "The cork pops out of the bottle and flies up into the air",
        "part throw",
    ),
    Case(
        "winebottle",
        "The bottle is made of rubber and bounces when it is dropped on the floor",
        "material drop",
    ),
    Case(
        "winebottle",
        "knock the bottle over so it rolls across the floor",
        "hit tip roll sequence",
    ),
    Case(
        "winebottle",
        "Someone bumps into it and the wine bottle wobbles back and forth but doesn't fall over",
        "hit sway",
    ),
    Case(
        "parkbench",
        "Tip the bench over backwards",
        "tip push",
    ),
    Case(
        "parkbench",
        "the bench is made of jelly and wobbles when it gets dropped on the floor",
        "material drop sway",
    ),
    Case(
        "parkbench",
        "Someone grabs the top of the backrest and pulls it back until it bends, then lets go.",
        "part bend sequence",
    ),
    Case(
        "parkbench",
        "A really strong gust of wind blows the bench sideways and it slides across the ground",
        "wind push",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentieth": _PAIRS}
