"""Pairs on a thirteenth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. Four
files are compressed with Draco. The cyclops is of the family of the ninth lot's monster.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

QUATERNIUS = "simondevyoutube/Quick_3D_RPG/bfeef5ccd670a1adc1d8d77da94900492e28f471/resources"
MARKET = "pmndrs/market-assets/c9cfa0236a012093edd5affe200808752375bd90/files/models"

FILES: Mapping[str, PinnedFile] = {
    "pirate": PinnedFile(
        "pirate-captain.gltf",
        f"{MARKET}/pirate-captain",
        "7a6dcd3e35ce0c588f3d6bb5f6f991e0dd7da1a4b688a25ed661ab4776fb6a53",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "tractor": PinnedFile(
        "tractor.gltf",
        f"{MARKET}/tractor",
        "3c73bf8a7005040107ee0d8ef990e57bcab81366251f27f5b6c7ec5121adddc1",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "cyclops": PinnedFile(
        "Cyclops.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "a46f9ddb7d47e5ed3d7fbfbc44cc0bc1ed41f8a5b5f0b32604c577d6b2aad1f5",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "pineapple": PinnedFile(
        "pineapple.gltf",
        f"{MARKET}/pineapple",
        "bc60858224c985e11159dd8af56c8562b34c1311c8c4bf8931fa28afe2e1067e",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "pot": PinnedFile(
        "pot-stew.gltf",
        f"{MARKET}/pot-stew",
        "2c1ea93b61bcb180b45d671fbfcf02420d42f9578466d0448f7a0dbf6c6b2d9d",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"cyclops": ("--up", "+y")})

_PAIRS = (
    Case("pirate", "the pirate lifts his right arm up", "part lift"),
    Case("pirate", "A strong gust of wind knocks the pirate over onto his back.", "wind tip violent"),
    Case("pirate", "the little guy jumps twice on the spot", "jump quantity"),
    Case(
        "pirate",
        "The pirate is made of rubber and somebody twists him at the waist, then lets go so he springs back",
        "material twist sequence",
    ),
    Case("tractor", "the tractor raises its front bucket", "part lift"),
    Case(
        "tractor",
        "Give the tractor a gentle push from behind so it rolls forward a little bit.",
        "push roll slight",
    ),
    Case("tractor", "tractor gets dropped from way up high and smashes into the ground", "drop violent"),
    Case("tractor", "a heavy ball slams into the side of the tractor and tips it over", "hit tip violent"),
    Case("cyclops", "make the monster out of jelly and drop it on the floor", "material drop"),
    Case(
        "cyclops", "Someone pokes the monster's big round eye and it gets pushed in a bit.", "part hit slight"
    ),
    Case("cyclops", "the one eyed monster hops forward, then falls flat on its face", "jump tip sequence"),
    Case(
        "cyclops",
        "squash this chubby little monster down from the top until it's about half as tall",
        "squeeze quantity",
    ),
    Case(
        "pineapple",
        "The leaves on top of the pineapple sway softly in a light breeze.",
        "part sway wind slight",
    ),
    Case("pineapple", "pineapple tips over and rolls away", "tip roll sequence"),
    Case("pineapple", "throw the pineapple hard at a wall", "throw violent"),
    Case(
        "pineapple",
        "I'd like the pineapple's green top to bend over to one side, like someone is pulling on it, while the "
        "fruit stays put.",
        "part bend",
    ),
    Case(
        "pot",
        "The pot is solid steel and clanks down on the floor after being dropped from about table height.",
        "material drop",
    ),
    Case("pot", "spin the pot around one full turn", "spin quantity"),
    Case("pot", "someone grabs the pot by one handle and lifts that side up so it's tilted", "part lift tip"),
    Case("pot", "a saucepan made of soft clay that gets squeezed from both sides", "material squeeze"),
)

SETS = {"thirteenth": _PAIRS}
