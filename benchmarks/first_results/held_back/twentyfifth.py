"""Pairs on a twenty-fifth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "honeyjar": PinnedFile(
        "honey.gltf",
        f"{MARKET}/honey",
        "7bc8ee6803e91af3e3dd94cc3d230afa18431340f89ed9b9f41559de473812b2",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "kenneytaxi": PinnedFile(
        "taxi.gltf",
        f"{MARKET}/taxi",
        "103aad9efef741362ab40e3c095fb492960bd4862b80cd7f53b01dfd52e39a10",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "stewpan": PinnedFile(
        "pan-stew.gltf",
        f"{MARKET}/pan-stew",
        "dd696749fcf107b6f5748fb437551eca10e1b8513c1caa5aa26a8d7383bc194a",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "cannonmobile": PinnedFile(
        "cannon-mobile.gltf",
        f"{MARKET}/cannon-mobile",
        "97f5e46a65dd89967f07547ae0d1b1a0e74a12b148ec894cab825f3c55fb3791",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "hotdog": PinnedFile(
        "hot-dog.gltf",
        f"{MARKET}/hot-dog",
        "b6b6e4d9037a359457488f1a8ab8332d4c8ea72b37001164b21cb2c970a6afff",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case("honeyjar", "tip the jar over and let it roll away", "tip roll"),
    Case(
        "honeyjar",
        "Make the honey jar out of soft rubber and drop it from about a metre up, so it bounces a few "
        "times before it settles.",
        "material drop jump",
    ),
    Case(
        "honeyjar",
        "The brown lid gets pulled off the top of the jar and falls on the floor next to it",
        "stretch",
    ),
    Case(
        "honeyjar",
        "Something heavy slowly presses down on the jar until it's squashed to about half its height, "
        "and then it gets lifted away and the jar stays flattened.",
        "squeeze lift sequence quantity",
    ),
    Case("kenneytaxi", "squash the taxi flat", "squeeze"),
    Case(
        "kenneytaxi",
        "The taxi is made of soft jelly. Drop it from about a metre up so it wobbles and jiggles when it "
        "lands.",
        "material drop sway",
    ),
    Case("kenneytaxi", "Snap the grey sign off the roof and let it tumble down onto the floor", "part"),
    Case(
        "kenneytaxi",
        "Please lift the cab a little way into the air, then flip it over so that it ends up lying "
        "upside down.",
        "lift sequence",
    ),
    Case("stewpan", "Tip the pan over onto its side", "tip"),
    Case("stewpan", "one of the white handles snaps off and falls on the floor", "part"),
    Case(
        "stewpan",
        "Make the whole thing out of soft jelly and drop it from about a metre up so it wobbles when it "
        "lands.",
        "material drop sway",
    ),
    Case(
        "stewpan",
        "Someone gives the pan a hard shove so it slides across the floor, and then it gets lifted "
        "straight up into the air.",
        "push lift sequence",
    ),
    Case(
        "cannonmobile",
        "the cannon gets dropped from about head height and tips over onto its side when it lands",
        "drop tip part",
    ),
    Case(
        "cannonmobile",
        "Make the barrel slowly sag and droop down at the front while the rest of the cannon stays put.",
        "push",
    ),
    Case(
        "cannonmobile",
        "Somebody gives it a hard shove from behind so it shoots forward across the floor, then it slows "
        "down and comes to a stop.",
        "push sequence",
    ),
    Case("cannonmobile", "squash it flat like a pancake", "squeeze"),
    Case("hotdog", "squash the hot dog flat like someone stepped on it", "squeeze"),
    Case(
        "hotdog",
        "Someone grabs the end of the sausage that's sticking out on the right and pulls until it "
        "stretches way out of the bun.",
        "stretch",
    ),
    Case(
        "hotdog",
        "Make the hot dog out of bouncy rubber and drop it from about a meter up so it bounces a few "
        "times before it stops.",
        "material drop jump",
    ),
    Case(
        "hotdog",
        "The hot dog gets tossed up, flips over once in the air, and then lands upside down and stays there.",
        "throw sequence",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentyfifth": _PAIRS}
