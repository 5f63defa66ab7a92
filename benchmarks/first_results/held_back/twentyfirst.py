"""Pairs on a twenty-first lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "deermonster": PinnedFile(
        "Deer.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "ecaca2e676c8fa065c15da059f8153998b305d1129a15fd0880b30bf19b6dc9a",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "pirateofficer": PinnedFile(
        "pirate-officer.gltf",
        f"{MARKET}/pirate-officer",
        "cb7170c739639bc0f0e2e5f800e1ac95fd31c11ce0d6dc5dc91b95dca1ebe8e5",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "van": PinnedFile(
        "van.gltf",
        f"{MARKET}/van",
        "e9d61a07792b62ca751917263069dddef530999e89119fe9cf9f8e41185d68db",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "cocktail": PinnedFile(
        "cocktail.gltf",
        f"{MARKET}/cocktail",
        "15a19fb7fc43335bc71d4c2d0b5f7ee185ef7ad172fe6afe248ad8c61ace624d",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "brownmushroom": PinnedFile(
        "mushroom.gltf",
        f"{MARKET}/mushroom",
        "4ec26cb2c4df51129bd60f46d500ffb407e19984aa0709c7e6b951328a71d8a0",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"deermonster": ("--up", "+y")})

_PAIRS = (
    Case(
        "deermonster", "make the deer's antlers flop backwards and then spring back up", "sway sequence part"
    ),
    Case(
        "deermonster",
        "The deer is made of soft jelly and it gets dropped from about a metre up, so it splats a"
        " bit and keeps wobbling after it lands.",
        "material drop sway sequence",
    ),
    Case("deermonster", "Someone pushes it over onto its back", "push"),
    Case(
        "deermonster",
        "I want it to be squashed flat from above like a heavy plate is pressing down, then let "
        "go so it pops back into shape",
        "squeeze sequence",
    ),
    Case("pirateofficer", "the pirate gets shoved from behind and falls flat on his face", "push tip"),
    Case(
        "pirateofficer",
        "His hat flies off in a gust of wind and lands on the floor behind him, while the rest of"
        " him stays standing.",
        "wind throw part",
    ),
    Case(
        "pirateofficer",
        "Make him out of jelly and drop him from about a metre up, so he squashes when he lands "
        "and then wobbles back into shape",
        "material drop sway squeeze sequence",
    ),
    Case(
        "pirateofficer",
        "Someone picks the pirate up high, spins him around a couple of times like a top, then "
        "lets go and he tumbles across the floor.",
        "spin lift sequence",
    ),
    Case("van", "drop it on its roof", "drop"),
    Case(
        "van",
        "The van is made of soft jelly, and someone pushes down hard on it from above and then "
        "lets go so it wobbles back into shape.",
        "material push sway sequence",
    ),
    Case("van", "one of the front wheels comes off and rolls away", "roll part"),
    Case(
        "van",
        "A strong gust of wind hits the van from the side and tips it over, then it slides a "
        "little way along the floor before it stops",
        "push hit tip wind sequence",
    ),
    Case("cocktail", "tip the cocktail over", "tip"),
    Case(
        "cocktail",
        "Somebody drops this drink from about table height, it hits the floor and smashes to pieces.",
        "drop hit",
    ),
    Case(
        "cocktail",
        "The lemon slice slips off the rim and falls to the floor, while everything else stays standing.",
        "drop part",
    ),
    Case(
        "cocktail",
        "Give the cocktail a hard shove so it slides along the floor, then have it wobble and "
        "come to a stop still upright",
        "push sway sequence",
    ),
    Case(
        "brownmushroom",
        "The mushroom is made of soft jelly and gets dropped from about knee height, so it "
        "wobbles all over when it lands",
        "material drop sway",
    ),
    Case("brownmushroom", "knock it over", "hit tip"),
    Case(
        "brownmushroom",
        "Someone grabs the brown cap and twists it around hard, then lets go and it springs back.",
        "twist sequence part",
    ),
    Case(
        "brownmushroom",
        "Squash the mushroom flat from above like a big hand is pressing on it, hold it there a "
        "second, and then let it slowly puff back up to its normal shape",
        "squeeze sequence",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentyfirst": _PAIRS}
