"""Pairs on a fourteenth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. Four
files are compressed with Draco. The crab is of the family of the ninth lot's monster.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "zombie": PinnedFile(
        "zombie-1.gltf",
        f"{MARKET}/zombie-1",
        "0d214121bdaaa0e463f8469919b090f083a07a3bd5571b5a1d488c999a78805c",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "firetruck": PinnedFile(
        "firetruck.gltf",
        f"{MARKET}/firetruck",
        "51f8df62ff7ec16d402544b3691344540a992b3791c1c8c7715b716a5d4b7a1f",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "mug": PinnedFile(
        "mug-1.gltf",
        f"{MARKET}/mug-1",
        "2851c5e19d595ac4f39703b6976de707ced5c0911796538bcbe33c9a1b193819",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "ship": PinnedFile(
        "ship-light.gltf",
        f"{MARKET}/ship-light",
        "5634dded81a04670f1021098ffa79c2c6273ca3e8f8a64abf52eac74b7e2ff63",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "crab": PinnedFile(
        "Crab.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "ca8ab4fab13b20477203d0a2e83744c46fbc48a502bd137cfbd6a139c80d1dd3",
        "mesh, by Quaternius, CC0-1.0",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"crab": ("--up", "+y")})

_PAIRS = (
    Case("zombie", "The zombie raises its right arm and lets it drop again.", "part lift sequence"),
    Case("zombie", "push the zombie over backwards", "push tip"),
    Case("zombie", "Make him out of jelly and drop him on the floor", "material drop"),
    Case("zombie", "TWIST THE ZOMBIE LIKE A WET TOWEL AND LET GO", "twist"),
    Case("firetruck", "A hand gives the fire truck a little push from behind.", "push slight roll"),
    Case("firetruck", "spin the front wheels", "part spin"),
    Case(
        "firetruck",
        "The fire truck races forward, slams into a wall and bounces back.",
        "violent hit sequence",
    ),
    Case("firetruck", "flip the truck over onto its roof!", "tip"),
    Case("mug", "Drop the mug", "drop"),
    Case("mug", "Pick the mug up by its handle and put it back down gently.", "part lift slight"),
    Case(
        "mug", "throw the mug at the ground like it's made of rubber so it bounces around", "throw material"
    ),
    Case("mug", "Tip the mug halfway over, then let it rock back upright.", "tip quantity sequence"),
    Case("ship", "the sails flap in a strong wind", "part wind"),
    Case("ship", "The ship rocks slowly from side to side as if it was on the sea.", "sway slight"),
    Case("ship", "Make the ship out of paper and let the wind blow it away.", "material wind"),
    Case("ship", "turn the ship a quarter turn to the left and then drop it", "spin quantity sequence"),
    Case("crab", "Bend its left claw down and let it spring back.", "part bend"),
    Case("crab", "squash the crab monster flat, it should be soft clay", "material squeeze"),
    Case("crab", "A heavy ball smashes into the monster from the side.", "hit violent"),
    Case("crab", "it hops twice and then falls on its back", "jump quantity sequence"),
)

SETS = {"fourteenth": _PAIRS}
