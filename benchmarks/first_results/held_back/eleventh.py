"""Pairs on an eleventh lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. The
pig is of the family of the ninth lot's monster. The character is called a robot in these.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

QUATERNIUS = "simondevyoutube/Quick_3D_RPG/bfeef5ccd670a1adc1d8d77da94900492e28f471/resources"

FILES: Mapping[str, PinnedFile] = {
    "pig": PinnedFile(
        "Pig.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "aad9385bd7ba98c19c4174b1719bdd8f6880210be4971a717d7e651d101aed8e",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "character": PinnedFile(
        "character.glb",
        "KenneyNL/Starter-Kit-3D-Platformer/3fa8a04b1c01ab23db43123d4ce814a34c3fc7f0/models",
        "7112f6a08400914f9da546f3e6029e947cc9eab2b4a6da5eb99776111289efb1",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
    ),
    "palm": PinnedFile(
        "PalmTree_1.obj",
        f"{QUATERNIUS}/nature/OBJ",
        "5df4a32b4f337661b7ade1f017ffab0701539de3f5eeb1dd7ab6d2c73a646cfb",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "motorcycle": PinnedFile(
        "vehicle-motorcycle.glb",
        "KenneyNL/Starter-Kit-Racing/2f2e5f2646dda89cb21d4e8539bab60c6e955dc8/models",
        "c97911b8dbc2d5dd9d1961b46eb4d1f132b67a6c5a84f45593fea44e0595dd92",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
    ),
    "bow": PinnedFile(
        "Bow_Wooden.obj",
        f"{QUATERNIUS}/weapons/OBJ",
        "788c9e72bdd839a86704113de4809a96cfedf09441bb3f98f383a7abfe751e6d",
        "mesh, by Quaternius, CC0-1.0",
    ),
}

# These files do not tell; their pictures show them upright.
THINGS = pin_things(FILES, dict.fromkeys(("pig", "palm", "bow"), ("--up", "+y")))

_PAIRS = (
    Case("pig", "The pig's big ears flap up and down.", "part sway"),
    Case("pig", "The pig is made of jelly and drops onto the floor.", "material drop"),
    Case("pig", "The pig jumps up high and then rolls over onto its side.", "sequence jump roll"),
    Case("pig", "The pig gets squashed flat from above.", "squeeze"),
    Case("character", "The robot jumps up and down three times.", "quantity jump"),
    Case("character", "The robot's head wobbles from side to side.", "part sway"),
    Case("character", "A rubber robot falls from high up and bounces.", "material drop"),
    Case("character", "The robot gets shoved really hard and topples over backwards.", "push tip violent"),
    Case("palm", "A hurricane bends the palm tree almost down to the ground.", "wind bend violent"),
    Case("palm", "The leaves of the palm flutter a little in a soft breeze.", "part wind slight"),
    Case("palm", "The palm tree takes a hard knock and shakes.", "hit sway"),
    Case("palm", "The tree is made of rubber and slowly gets twisted around.", "material twist"),
    Case("motorcycle", "The motorcycle gets a gentle nudge and tips over sideways.", "push tip slight"),
    Case("motorcycle", "The front wheel of the motorbike spins really fast.", "part spin"),
    Case("motorcycle", "The motorcycle does a wheelie and then slams back down.", "sequence lift tip"),
    Case("motorcycle", "Drop the motorcycle from two meters up.", "quantity drop"),
    Case("bow", "The bowstring gets pulled back and then let go.", "part sequence stretch"),
    Case("bow", "The bow rises and spins 360 degrees in the air.", "quantity spin lift"),
    Case("bow", "The bow is made of wood and clatters onto the floor.", "material drop"),
    Case("bow", "The bow is thrown across the room, tumbling as it flies.", "throw spin"),
)

SETS = {"eleventh": _PAIRS}
