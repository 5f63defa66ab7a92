"""Pairs on a fifteenth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. Four
files are compressed with Draco. The penguin is of the family of the ninth lot's monster, the skater of the zombie's.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "roundpenguin": PinnedFile(
        "Penguin.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "2dbafb5311b252c204171aae313000ccee089d0dcc4271a46478683cca7cd777",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "skater": PinnedFile(
        "skater-female.gltf",
        f"{MARKET}/skater-female",
        "77d1f30e1a4125b02077c9e54085a6b0b79f132e93a524dcf4732d5bf0f10b42",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "racecar": PinnedFile(
        "race-car.gltf",
        f"{MARKET}/race-car",
        "7a5e0c00126ff2d0c53e2a495b6e82ccf1852f73f6e08242a5e9e508e6e6b34e",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "pillow": PinnedFile(
        "pillow.gltf",
        f"{MARKET}/pillow",
        "540be155f822a305bc2a24860809921b96fa46279ffbdcb2aaedb6bf08edd135",
        "mesh, by Sara Vieira, CC0-1.0",
        "model.gltf",
    ),
    "fryingpan": PinnedFile(
        "frying-pan.gltf",
        f"{MARKET}/frying-pan",
        "bf1db4d3691c27993e05ebde0dddd79745b242589f02a534bdc18c501321b51b",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"roundpenguin": ("--up", "+y")})

_PAIRS = (
    Case(
        "roundpenguin",
        "the fat little bird flaps both wings twice and then does a small hop",
        "part sequence jump quantity",
    ),
    Case(
        "roundpenguin",
        "A bird made of wobbly jelly falls from about its own height and jiggles when it lands.",
        "material drop",
    ),
    Case(
        "roundpenguin",
        "Squash it from above to half its height, then let it pop back up.",
        "squeeze quantity sequence",
    ),
    Case(
        "roundpenguin",
        "it rocks gently from side to side like a roly-poly toy but never falls over",
        "sway slight",
    ),
    Case(
        "skater",
        "He slowly lowers his right arm until it hangs down by his side, the other arm stays where it is.",
        "part",
    ),
    Case(
        "skater",
        "The boy jumps straight up, lands on his feet, and then topples flat onto his face.",
        "jump tip sequence",
    ),
    Case("skater", "A HUGE GUST OF WIND KNOCKS HIM OVER BACKWARDS!!", "wind violent tip"),
    Case("skater", "turn his head a little to the left", "part twist slight quantity"),
    Case(
        "racecar",
        "someone gives the race car a soft push from behind and it rolls forward a bit and stops",
        "push roll slight",
    ),
    Case(
        "racecar",
        "One of the front wheels breaks off and rolls away while the car sags down on that corner.",
        "part roll sequence",
    ),
    Case(
        "racecar",
        "Hurl the car through the air so that it crashes to the ground and tumbles over and over.",
        "throw violent",
    ),
    Case("racecar", "the rear wing gets bent backwards, rest of the car doesn't move", "part bend"),
    Case("pillow", "Punch the cushion hard right in the middle.", "hit violent"),
    Case(
        "pillow",
        "Grab the pillow at both ends and wring it like a wet towel, about half a turn, then let go.",
        "twist quantity sequence",
    ),
    Case(
        "pillow",
        "pick the pillow up by one of its top corners and let it dangle and swing softly",
        "part lift sway",
    ),
    Case(
        "pillow",
        "The pillow drops from high up, but it is solid stone, so it hits the floor with a thud "
        "and does not squish at all.",
        "material drop",
    ),
    Case(
        "fryingpan",
        "Lift the pan by its wooden handle, tilt it halfway over as if pouring something out, and set it back down.",
        "part lift tip sequence quantity",
    ),
    Case("fryingpan", "pan spins round and round flat on the floor, getting slower until it stops", "spin"),
    Case(
        "fryingpan", "The frying pan turns out to be soft rubber and slowly folds in half.", "material bend"
    ),
    Case(
        "fryingpan",
        "something heavy slams into the side of the pan and sends it flying across the floor",
        "hit violent",
    ),
)

SETS = {"fifteenth": _PAIRS}
