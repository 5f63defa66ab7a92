"""Pairs on a twenty-eighth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "watermelon": PinnedFile(
        "watermelon.gltf",
        f"{MARKET}/watermelon",
        "483529e49dfac878e558882d774b4d8b6574d05e8a9433a8e9625648c5eeee16",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "oilbottle": PinnedFile(
        "bottle-oil.gltf",
        f"{MARKET}/bottle-oil",
        "b905b1bba4b35cbed0360921f7231a23f3ea6aeea26a115152b62a2607f82cbc",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "plaintruck": PinnedFile(
        "truck.gltf",
        f"{MARKET}/truck",
        "e74a0d7e070764bc33803b8bb5c09bf55d20dc35666cda732b8211271bc9fa58",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "bigtree": PinnedFile(
        "tree-big.gltf",
        f"{MARKET}/tree-big",
        "449fca266bfa6612502031c57f511b56513e169bf8a8fd2ed54d152bf7454aa2",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "survivorman": PinnedFile(
        "survivor-male.gltf",
        f"{MARKET}/survivor-male",
        "5288c08f5e05a62d8fcbe0457881f0435be8ec8e489831c35af1560a6206be11",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case(
        "watermelon",
        "watermelon rolls across the floor",
        "roll",
    ),
    Case(
        "watermelon",
        "The little brown stem on top wiggles from side to side while the rest of the melon stays still.",
        "part",
    ),
    Case(
        "watermelon",
        "make it out of super soft jelly and have a hand poke it from the side so it jiggles all over",
        "material sway",
    ),
    Case(
        "watermelon",
        "The watermelon drops from about a metre up and bounces a couple of times on the floor, and"
        " then, once it has landed, it splits open down the middle and the two halves fall apart to"
        " the left and right.",
        "drop jump sequence",
    ),
    Case(
        "oilbottle",
        "bottle tips over and falls",
        "drop tip",
    ),
    Case(
        "oilbottle",
        "The cork pops off the top of the bottle and flies up into the air.",
        "part",
    ),
    Case(
        "oilbottle",
        "make it out of real glass, drop it on the floor and it smashes into pieces",
        "material drop hit",
    ),
    Case(
        "oilbottle",
        "A hand pushes the bottle so that it wobbles back and forth a few times, and then it loses "
        "its balance, falls on its side and slides a little across the floor.",
        "drop push sway sequence",
    ),
    Case(
        "plaintruck",
        "truck drives forward",
        "push",
    ),
    Case(
        "plaintruck",
        "Make the front wheels turn left and then right, like someone is steering while it's parked.",
        "spin sequence part",
    ),
    Case(
        "plaintruck",
        "the whole pickup is made of squishy jelly and gets dropped on the floor, it should wobble "
        "like crazy when it lands",
        "material drop lift sway",
    ),
    Case(
        "plaintruck",
        "The pickup truck speeds forward quickly for a couple of seconds, then brakes hard so that "
        "its nose dips down and the back end lifts up a little before it settles.",
        "lift sequence",
    ),
    Case(
        "bigtree",
        "tree swaying in the wind",
        "wind sway",
    ),
    Case(
        "bigtree",
        "Make the green top wobble from side to side while the trunk stays still.",
        "sway part",
    ),
    Case(
        "bigtree",
        "its made of jelly and a hand pokes it near the top so it jiggles all over",
        "material sway",
    ),
    Case(
        "bigtree",
        "A strong gust of wind bends the tree far over to the right, and then it snaps back upright"
        " and rocks back and forth a few times until it stops.",
        "wind bend sequence",
    ),
    Case(
        "survivorman",
        "make the guy jump up and down",
        "jump",
    ),
    Case(
        "survivorman",
        "He raises his right arm and waves hello.",
        "part",
    ),
    Case(
        "survivorman",
        "turn him into wobbly jelly and have a big hand poke him in the belly so he jiggles all over",
        "material spin sway",
    ),
    Case(
        "survivorman",
        "The man slowly turns his head to look to the left, and after that he loses his balance and"
        " falls flat on his back on the floor.",
        "drop spin sequence",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentyeighth": _PAIRS}
