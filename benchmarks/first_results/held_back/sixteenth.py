"""Pairs on a sixteenth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. Four
files are compressed with Draco. The ambulance is of the family of the fourteenth lot's fire engine; another guitar and
another palm were used before, by other makers.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "bat": PinnedFile(
        "Bat.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "81d5845f5ddf6fe2666075ae6061389820e2edfa0daa82e59bf8fdb508d6fd4b",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "acousticguitar": PinnedFile(
        "guitar.gltf",
        f"{MARKET}/guitar",
        "078a09e593735d59838102d25b522f380e1afdb6984b4d17f7243c5aaee8e5b9",
        "mesh, by ruwo, CC0-1.0",
        "model.gltf",
    ),
    "longpalm": PinnedFile(
        "palm-long.gltf",
        f"{MARKET}/palm-long",
        "043fb52433a7f59d35a29a941b7b0a57eec9009e645ccd8ad1c1432d48a09598",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "burger": PinnedFile(
        "burger.gltf",
        f"{MARKET}/burger",
        "4b93b75882da9d5e8e98bce1a96112b4f7f3e845f179cd5db26f44395e64d641",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "ambulance": PinnedFile(
        "ambulance.gltf",
        f"{MARKET}/ambulance",
        "19b5bcc7cca05144fc2a39385511af7100aa4d926eb062cdfcc4abe7f7d25075",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"bat": ("--up", "+y")})

_PAIRS = (
    Case(
        "bat",
        "flap both wings three times, body stays put on the floor",
        "part quantity stillness sway",
    ),
    Case(
        "bat",
        "MAKE HIM HOP BACKWARDS TWICE",
        "jump quantity",
    ),
    Case(
        "bat",
        "ok so what if this little guy was made of jelly and somebody poked him right between the eyes, i'd "
        "love to see him wobble all over",
        "material part hit sway",
    ),
    Case(
        "bat",
        "His big ears slowly droop like wet cloth and after that he topples forward onto his face.",
        "part material sequence bend tip",
    ),
    Case(
        "acousticguitar",
        "guitar smashed headstock first into the ground",
        "part hit throw",
    ),
    Case(
        "acousticguitar",
        "Could it twirl on its bottom edge like a spinning top for about one and a half turns, and then "
        "keel over to the left?",
        "spin sequence quantity tip",
    ),
    Case(
        "acousticguitar",
        "the neck is rubber. somebody yanks the top of it toward the back and lets go so it whips back and "
        "forth but the body of the guitar does not budge",
        "part material sequence stillness bend sway",
    ),
    Case(
        "acousticguitar",
        "a gentle nudge from behind, it rocks a bit but never actually tips over",
        "push stillness",
    ),
    Case(
        "longpalm",
        "hurricane from the right side, trunk leans nearly to the ground then straightens up again once the "
        "wind dies down",
        "wind bend sequence part",
    ),
    Case(
        "longpalm",
        "only the leaves rustling in a light breeze please, trunk perfectly still",
        "part wind stillness",
    ),
    Case(
        "longpalm",
        "I'd like to watch the palm go limp and sag like an overcooked noodle until it's a heap on the floor",
        "material bend tip",
    ),
    Case(
        "longpalm",
        "RIP IT OUT OF THE GROUND STRAIGHT UP AND DANGLE IT UPSIDE DOWN",
        "lift sequence spin",
    ),
    Case(
        "burger",
        "squash the burger from above till it's half as tall then release it so it puffs back up",
        "squeeze sequence quantity material",
    ),
    Case(
        "burger",
        "top bun pops off and flies in the air",
        "part jump",
    ),
    Case(
        "burger",
        "The meat patty gets slid out sideways, toward the right, while the buns and everything else remain stacked.",
        "part push stillness",
    ),
    Case(
        "burger",
        "solid steel burger plummets from around 2 meters and just clunks, no bounce at all",
        "material drop quantity stillness",
    ),
    Case(
        "ambulance",
        "ambulance rolls forward about one car length and then brakes so hard the nose dips",
        "push sequence quantity part",
    ),
    Case(
        "ambulance",
        "hoist the back end up until only the front bumper is touching, hold it there a second, let it "
        "crash down on its rear wheels",
        "part lift sequence drop",
    ),
    Case(
        "ambulance",
        "it's a bouncy castle ambulance!! chuck it across the floor and let it boing maybe 3 or 4 times "
        "before it settles",
        "material throw quantity sequence",
    ),
    Case(
        "ambulance",
        "the blue light on the cab roof comes loose and tumbles down over the hood",
        "part tip",
    ),
)

SETS = {"sixteenth": _PAIRS}
