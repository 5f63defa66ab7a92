"""Pairs on an eighteenth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. Four
files are compressed with Draco.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "demon": PinnedFile(
        "Demon.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "87a8f7e876f65b97139bc2a8185ca1e30bf37cc02ae3c7ff6801fd961b07b17b",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "eggcup": PinnedFile(
        "egg-cup.gltf",
        f"{MARKET}/egg-cup",
        "065546668a81344cd59733d1f49a80ade78027e66ac1463d8cd34d85615515de",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "oldvan": PinnedFile(
        "citroen-old-van.gltf",
        f"{MARKET}/citroen-old-van",
        "5ba709ad0c7d88e8572c01d41d7a7f19fbc02642940479dbfb06cf6d6ee22026",
        "mesh, by creativetrio, CC0-1.0",
        "model.gltf",
    ),
    "tower": PinnedFile(
        "tower.gltf",
        f"{MARKET}/tower",
        "57bea0b9558f14e8e6317a40b344952a863443f96ff4fa229fd83ffa70dfd76a",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "lucy": PinnedFile(
        "lucy.gltf",
        f"{MARKET}/lucy",
        "e2002b46194cc54de8ba5b8eb0eb758b95ee86783abc6cebc001493029c3a2ca",
        "mesh, by the Stanford Computer Graphics Laboratory, for research",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"demon": ("--up", "+y")})

_PAIRS = (
    Case(
        "demon",
        "yo make its ears flap like rubber while the rest of the head doesnt budge",
        "part material bend stillness",
    ),
    Case(
        "demon",
        "The monster's head rolls forward onto its face and comes to rest.",
        "roll part sequence",
    ),
    Case(
        "demon",
        "DROP THIS UGLY THING FROM WAY UP HIGH AND LET IT BOUNCE THREE TIMES LIKE A BASKETBALL",
        "drop violent quantity",
    ),
    Case(
        "demon",
        "Someone grabs both horns and slowly pulls them apart until the jelly head gets wider, then "
        "lets go and it wobbles back.",
        "stretch part material sequence",
    ),
    Case(
        "eggcup",
        "Tip the egg cup over.",
        "tip",
    ),
    Case(
        "eggcup",
        "A small ball hits the rim and the cup rocks a little but doesn't fall over.",
        "hit part slight",
    ),
    Case(
        "eggcup",
        "could you please give it a gentle twist at the narrow middle so the bowl turns one way "
        "while the foot stays put, as if it were made of clay?",
        "twist part material slight stillness",
    ),
    Case(
        "eggcup",
        "spin it like a top untill it gets wobbly n falls on its side",
        "spin tip sequence",
    ),
    Case(
        "oldvan",
        "The van gets shoved hard from behind, slams into a wall and bounces back a bit.",
        "push wall violent sequence",
    ),
    Case(
        "oldvan",
        "squish the roof down like its a foam toy n let it pop back up",
        "squeeze part material sequence",
    ),
    Case(
        "oldvan",
        "Gusts of wind from the side make the old van rock gently on its wheels.",
        "wind sway slight",
    ),
    Case(
        "oldvan",
        "Make it hop twice.",
        "jump quantity",
    ),
    Case(
        "tower",
        "I'd like to see the tower lean over to the left, quiver for a moment, and straighten up "
        "again, with its rocks at the bottom not moving at all.",
        "bend sequence stillness part space",
    ),
    Case(
        "tower",
        "a cannonball smashes into the battlements and the whole thing topples backwards",
        "hit part violent tip space",
    ),
    Case(
        "tower",
        "The solid stone tower does not move even though a strong storm blows against it.",
        "wind material stillness",
    ),
    Case(
        "tower",
        "lift it a tiny bit off the ground, hold it there, then let it thud down",
        "lift drop sequence slight",
    ),
    Case(
        "lucy",
        "The angel's wings beat slowly, twice, and she stays standing on her pedestal.",
        "part bend quantity stillness",
    ),
    Case(
        "lucy",
        "Paper angel blown away by the wind.",
        "wind material",
    ),
    Case(
        "lucy",
        "push the torch arm back with one finger, its like soft wax so it stays bent",
        "push bend part material slight",
    ),
    Case(
        "lucy",
        "Please throw the statue about two metres to the right so that it lands on its back and "
        "slides to a stop.",
        "throw quantity space sequence violent",
    ),
)

SETS = {"eighteenth": _PAIRS}
