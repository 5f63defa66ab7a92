"""Pairs on a twenty-seventh lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "strawberry": PinnedFile(
        "strawberry.gltf",
        f"{MARKET}/strawberry",
        "ad0850e77ae28a1a4a345e8411e0ac511c699227779a596cef5b3f073db10913",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "pizzacutter": PinnedFile(
        "pizza-cutter.gltf",
        f"{MARKET}/pizza-cutter",
        "cc9215540946ae3e53feaded8fb32d6900ea7fdb3d7936513df579386368fb24",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "scimitar": PinnedFile(
        "sword-scimitar.gltf",
        f"{MARKET}/sword-scimitar",
        "6608ff5c67fedf68c45bec7eb3fbe47a107b6e7c8709fc42eebed45103e85f6b",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "eggplant": PinnedFile(
        "eggplant.gltf",
        f"{MARKET}/eggplant",
        "51144de7902555e6dfe125f18810e8a05fe163df4112943f02aa58adce36c473",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "hatchback": PinnedFile(
        "hatchback.gltf",
        f"{MARKET}/hatchback",
        "81d239fa4365b0e2deaf6122daf46567795abf845a5bed1d077552e9aecebb0d",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case(
        "strawberry",
        "make the strawberry bounce up and down",
        "jump",
    ),
    Case(
        "strawberry",
        "The green leaves on top flutter gently in the wind while the berry itself stays still.",
        "wind part",
    ),
    Case(
        "strawberry",
        "its made of soft jelly and a hand pokes it from the side so it wobbles all over",
        "material sway",
    ),
    Case(
        "strawberry",
        "The strawberry spins around on its tip like a spinning top, then it slows down, tips over "
        "and rolls a little way across the floor before it stops.",
        "tip roll spin sequence",
    ),
    Case(
        "pizzacutter",
        "pizza cutter rolls across the floor",
        "roll",
    ),
    Case(
        "pizzacutter",
        "The round blade spins quickly around its center while the handle stays still.",
        "spin part",
    ),
    Case(
        "pizzacutter",
        "make the whole thing out of soft rubber, it drops on the floor and wobbles and bends when "
        "it bounces",
        "material drop jump bend sway",
    ),
    Case(
        "pizzacutter",
        "First the pizza cutter stands up on the edge of its wheel and rolls forward a little, then"
        " it tips over sideways and falls flat on the floor with the wooden handle bouncing once.",
        "material drop tip roll sequence",
    ),
    Case(
        "scimitar",
        "sword spins around in the air",
        "spin",
    ),
    Case(
        "scimitar",
        "The blade bends slowly to one side, then springs back and wobbles a little, while the "
        "handle stays still.",
        "bend sway sequence part",
    ),
    Case(
        "scimitar",
        "make the whole sword out of soft rubber and drop it on the floor so it flops and bounces",
        "material drop jump",
    ),
    Case(
        "scimitar",
        "I'd like the sword to lift up off the ground and make a big fast slash from right to left "
        "as if someone was swinging it, and after that it falls down and lands flat on its side on "
        "the floor.",
        "drop lift sequence",
    ),
    Case(
        "eggplant",
        "make the eggplant bounce up and down",
        "jump",
    ),
    Case(
        "eggplant",
        "The green stem on top bends over to one side and then springs back.",
        "bend sequence part",
    ),
    Case(
        "eggplant",
        "its made of really soft jelly and gets dropped on the floor, lots of wobbling pls",
        "material drop",
    ),
    Case(
        "eggplant",
        "The eggplant slowly tips over and falls onto its side, and after that it rolls across the "
        "floor to the right until it comes to a stop.",
        "drop tip roll sequence",
    ),
    Case(
        "hatchback",
        "car drives forward",
        "push",
    ),
    Case(
        "hatchback",
        "The front wheels turn to the left and then to the right, like someone is steering.",
        "spin sequence part",
    ),
    Case(
        "hatchback",
        "make it out of jelly and drop it on the floor so it wobbles all over lol",
        "material drop sway",
    ),
    Case(
        "hatchback",
        "The car speeds off in a straight line, then brakes hard so that the nose dips down and the"
        " back end lifts up a little before it settles.",
        "lift sequence",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentyseventh": _PAIRS}
