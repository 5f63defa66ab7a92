"""Pairs on a twenty-ninth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "ham": PinnedFile(
        "wholer-ham.gltf",
        f"{MARKET}/wholer-ham",
        "25ae79270a1dae06238d8a2718c1cd8f3864bfb45e0b51caff485955fdcd2bdd",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "lespaul": PinnedFile(
        "les-paul.gltf",
        f"{MARKET}/les-paul",
        "195aeaff828211fc3aef4b0c9324d2115197ebd744995f08f94e945a09539f2d",
        "mesh, by simonrepp (blendswap.com), CC0-1.0",
        "model.gltf",
    ),
    "broccoli": PinnedFile(
        "broccoli.gltf",
        f"{MARKET}/broccoli",
        "c6e520610af8bdc35df86afa6989bc363c11c7e5081524313045a17cd90be991",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "plainman": PinnedFile(
        "male.gltf",
        f"{MARKET}/male",
        "b48c2a139b82378eacb98ee699d63eb2eb4da6d28d0a619e059dd6c5abaab2f6",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "lemon": PinnedFile(
        "lemon.gltf",
        f"{MARKET}/lemon",
        "669b580dcb249ba34762c692594eb90334c5b9bb0ea492e66f2a6ee47357301e",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case(
        "ham",
        "the ham drops on the floor",
        "drop",
    ),
    Case(
        "ham",
        "Someone pulls on the bone until it snaps off the meat",
        "part",
    ),
    Case(
        "ham",
        "make the ham out of jelly so it wobbles like crazy when it lands",
        "material sway",
    ),
    Case(
        "ham",
        "the ham rolls across the floor and bumps into a wall, then it bounces back, spins around on "
        "its side a couple of times and slowly comes to a stop",
        "jump push roll sequence spin",
    ),
    Case(
        "lespaul",
        "the guitar gets smashed on the floor",
        "hit",
    ),
    Case(
        "lespaul",
        "the neck snaps off and falls to the ground while the body stays standing",
        "drop part",
    ),
    Case(
        "lespaul",
        "make the guitar out of jelly so it flops over and jiggles all over the place when it lands",
        "material sway",
    ),
    Case(
        "lespaul",
        "The guitar spins around a couple of times like it's on stage, then it jumps up in the air, "
        "comes down hard on its bottom and finally tips over backwards and lies flat on the ground.",
        "jump sequence spin tip",
    ),
    Case(
        "broccoli",
        "the broccoli falls over",
        "drop",
    ),
    Case(
        "broccoli",
        "the big top piece snaps off the broccoli and rolls away on the floor",
        "part roll",
    ),
    Case(
        "broccoli",
        "make the broccoli out of jelly and drop it so it wobbles all over the place",
        "drop material sway",
    ),
    Case(
        "broccoli",
        "The broccoli jumps up and down a couple of times, then spins around really fast, and finally"
        " it tips over and all the little florets break off the stem.",
        "jump sequence spin tip",
    ),
    Case(
        "plainman",
        "the man falls flat on his face",
        "drop",
    ),
    Case(
        "plainman",
        "his big head wobbles from side to side like a bobblehead",
        "part sway",
    ),
    Case(
        "plainman",
        "make him out of jelly and drop him on the floor so he squishes and jiggles all over",
        "drop material sway",
    ),
    Case(
        "plainman",
        "The angry guy jumps up and down twice, then something pushes him hard from behind and he "
        "tips over, slides along the ground a bit and stops.",
        "jump push sequence tip",
    ),
    Case(
        "lemon",
        "the lemon rolls across the floor",
        "roll",
    ),
    Case(
        "lemon",
        "spin it like a top on its little pointy bottom until it tips over",
        "part spin tip",
    ),
    Case(
        "lemon",
        "Make the lemon out of glass and drop it so it smashes into pieces",
        "drop hit material",
    ),
    Case(
        "lemon",
        "lemon falls from up high and bounces a couple times, then rolls away to the right, and after"
        " it stops something heavy comes down and squashes it flat",
        "drop jump roll sequence squeeze",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentyninth": _PAIRS}
