"""Pairs on a twenty-fourth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "kenneyfish": PinnedFile(
        "fish.gltf",
        f"{MARKET}/fish",
        "385bc1b55150986917ca85e8193684efb2dc41f2ab19cd2b53b112662a961a3a",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "piratecrew": PinnedFile(
        "pirate-crew.gltf",
        f"{MARKET}/pirate-crew",
        "7266554ae46c6530a1da4130563844bf5491d480fc2e499c13fde5284c0a986f",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "deliverytruck": PinnedFile(
        "delivery-truck.gltf",
        f"{MARKET}/delivery-truck",
        "f14b43e56073e0fb6696273f867b3c309c08a1432eaf2c06ca8bbcfa8662091c",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "tajine": PinnedFile(
        "tajine.gltf",
        f"{MARKET}/tajine",
        "921f34fe6ecdfd91bb8a2a0b3d061bfe1adc41a53c9b05a174ccc4e1918d0891",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "cupcake": PinnedFile(
        "cupcake.gltf",
        f"{MARKET}/cupcake",
        "3a3db01e9c368927bcdb513926e3548aac6ce88017c82e95d94246e6d40f67a9",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case(
        "kenneyfish",
        "the fish is made of jelly, drop it from about a meter up and let it wobble when it lands",
        "material drop sway",
    ),
    Case("kenneyfish", "Bend the tail over to one side, then let go so it springs back.", "bend sequence"),
    Case(
        "kenneyfish",
        "Someone pushes down hard on the fish until it's squashed flat, and after that they lift "
        "their hand and it slowly puffs back up to its normal shape.",
        "push squeeze lift sequence part",
    ),
    Case("kenneyfish", "flip it upside down", "push"),
    Case(
        "piratecrew",
        "Someone gives the pirate a hard shove in the chest and he topples over flat on his back.",
        "push tip",
    ),
    Case("piratecrew", "make him jump straight up and land back on his feet", "jump"),
    Case(
        "piratecrew",
        "A giant hand squashes the pirate down to half his height, then lets go and he springs back"
        " to his normal shape.",
        "squeeze sequence quantity part",
    ),
    Case(
        "piratecrew",
        "his left arm comes off and drops to the floor while the rest of him stays standing",
        "drop part",
    ),
    Case("deliverytruck", "tip the truck over onto its side", "tip"),
    Case(
        "deliverytruck",
        "The truck is made of soft jelly and it falls from about a meter up, so it squashes flat "
        "when it lands and then wobbles for a while.",
        "material drop sway squeeze sequence",
    ),
    Case(
        "deliverytruck",
        "Someone presses down hard on the big green box until it caves in, while the grey cab in "
        "front stays the way it is",
        "squeeze",
    ),
    Case(
        "deliverytruck",
        "A strong gust of wind shoves it backwards across the floor, then it slides to a stop",
        "push wind sequence",
    ),
    Case("tajine", "drop it from shoulder height so it smashes into pieces", "drop hit"),
    Case(
        "tajine",
        "The dish is made of soft jelly and it wobbles around after someone gives it a good shove "
        "from the side.",
        "material push sway",
    ),
    Case(
        "tajine",
        "Somebody pinches the rim on one side and pulls it upward until the dish tips, then lets go"
        " and it falls back down flat.",
        "tip stretch sequence",
    ),
    Case(
        "tajine",
        "Flip the tajine upside down in the air, then let it land and slide across the floor until it stops.",
        "push sequence",
    ),
    Case("cupcake", "squash the cupcake flat", "squeeze part"),
    Case(
        "cupcake",
        "The cherry gets plucked off the top and then dropped on the floor next to the cupcake.",
        "drop sequence part",
    ),
    Case(
        "cupcake",
        "Make it out of jelly and drop it from about a meter up so it wobbles like crazy when it lands",
        "material drop sway",
    ),
    Case(
        "cupcake",
        "Someone bumps into it and it tips over onto its side, then it rolls a little way to the "
        "right and stops.",
        "hit tip roll sequence",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentyfourth": _PAIRS}
