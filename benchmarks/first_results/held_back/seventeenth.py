"""Pairs on a seventeenth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. Four
files are compressed with Draco.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "cthulhu": PinnedFile(
        "Cthulhu.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "86ba0114ec5759973fce3b079401c6227ee013375ad5fe45c014b0885b7e6db0",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "cyborg": PinnedFile(
        "cyborg-female.gltf",
        f"{MARKET}/cyborg-female",
        "490bbeb86dda2edf394f362048e835c1315fa60ed19704c81f9ceeafc044662c",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "icecreamtruck": PinnedFile(
        "ice-cream-truck.gltf",
        f"{MARKET}/ice-cream-truck",
        "4c3fc5f612475f5bea12704d793af114e82fb4e83a8f69123d4e61a271f6c13d",
        "mesh, by creativetrio, CC0-1.0",
        "model.gltf",
    ),
    "cherries": PinnedFile(
        "cherries.gltf",
        f"{MARKET}/cherries",
        "2395292cb3be92e38b8c16a439e468639665180824ed5af67e1d6fcdb81bb213",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "pottedplant": PinnedFile(
        "plant.gltf",
        f"{MARKET}/plant",
        "4bdb0d87ab0c8ba467e13cbf578198e0cd7e102b310efacf79141c0e7b3f5b8d",
        "mesh, by Sara Vieira, CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"cthulhu": ("--up", "+y")})

_PAIRS = (
    Case(
        "cthulhu",
        "flaps both wings three times",
        "part quantity bend",
    ),
    Case(
        "cthulhu",
        "ok so imagine the little monster is made of jelly and somebody drops it from pretty high up, i "
        "want to see it splat and wobble when it lands",
        "drop material",
    ),
    Case(
        "cthulhu",
        "SQUISH HIM FLAT FROM THE TOP THEN LET HIM POP BACK UP",
        "squeeze sequence violent",
    ),
    Case(
        "cthulhu",
        "The tentacles on its face sway gently from side to side while the body and wings remain perfectly "
        "still.",
        "sway part slight stillness",
    ),
    Case(
        "cyborg",
        "falls flat on her back",
        "tip",
    ),
    Case(
        "cyborg",
        "she jumps up twice on the spot, and the second jump should be way higher than the first",
        "jump quantity sequence",
    ),
    Case(
        "cyborg",
        "pull her grey robot arm realy long like its made of rubber then let go",
        "stretch part material sequence",
    ),
    Case(
        "cyborg",
        "Her upper body twists slowly to one side, as if she were looking behind her, while her feet stay "
        "planted on the floor.",
        "twist part stillness",
    ),
    Case(
        "icecreamtruck",
        "truck rolls forward about one length and stops",
        "roll quantity sequence",
    ),
    Case(
        "icecreamtruck",
        "can you make the big ice cream cone on the roof wobble back and forth like someone bumped it? the "
        "truck itself shouldn't move",
        "sway part stillness",
    ),
    Case(
        "icecreamtruck",
        "TRUCK GETS THROWN HARD INTO A WALL AND BOUNCES OFF",
        "throw wall violent sequence",
    ),
    Case(
        "icecreamtruck",
        "The truck, now made of soft clay, is struck on its left side and keeps the dent.",
        "hit material part",
    ),
    Case(
        "cherries",
        "spin fast on the stems like a top",
        "spin violent",
    ),
    Case(
        "cherries",
        "a light breeze comes by and just the leaf flutters a bit, the cherries don't budge",
        "wind part slight stillness",
    ),
    Case(
        "cherries",
        "make them steel and drop from 1 metre, no bouncing just a heavy thud",
        "drop material quantity",
    ),
    Case(
        "cherries",
        "The pair is lifted by the top of the stems, hangs in the air for a moment with the two cherries "
        "swinging, and is then let go.",
        "lift part sway sequence drop",
    ),
    Case(
        "pottedplant",
        "strong wind from the left, leaves bend over",
        "wind bend part violent",
    ),
    Case(
        "pottedplant",
        "i'd love to see the plant get a small shove so the pot rocks a couple times and then settles back "
        "upright",
        "push slight tip sequence",
    ),
    Case(
        "pottedplant",
        "whole plant floating in zero gravity slowly tumbling",
        "space spin slight",
    ),
    Case(
        "pottedplant",
        "The tallest leaf is bent down towards the floor and released, so that it springs back and quivers "
        "before coming to rest.",
        "bend part sequence sway",
    ),
)

SETS = {"seventeenth": _PAIRS}
