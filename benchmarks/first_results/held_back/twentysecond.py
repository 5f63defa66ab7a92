"""Pairs on a twenty-second lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "headphones": PinnedFile(
        "headphones.gltf",
        f"{MARKET}/headphones",
        "9d60f2344abcfbb39bc1d410c2a1a9836f0897d27bb52dc7fc2ff0fdceb0d6fb",
        "mesh, by sudeepsingh, CC0-1.0",
        "model.gltf",
    ),
    "windturbine": PinnedFile(
        "wind-turbine.gltf",
        f"{MARKET}/wind-turbine",
        "3edeb91313bd93f428ef359a531b34ad18c5d831dbcee305ce27b1a35ee04125",
        "mesh, by creativetrio, CC0-1.0",
        "model.gltf",
    ),
    "survivor": PinnedFile(
        "survivor-female.gltf",
        f"{MARKET}/survivor-female",
        "c6b393a8b8403fa25e4e2af97828349e8954aac04cf6d2257e220c9852c31b19",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "shovel": PinnedFile(
        "shovel.gltf",
        f"{MARKET}/shovel",
        "a33f2fb648fc97ea7c7fcf657afbc401291c8e822bb5ccae00354452c17a5053",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "smallboat": PinnedFile(
        "boat-small.gltf",
        f"{MARKET}/boat-small",
        "2390ff771649646ec44d546747a43c137eac805cfe3505297dd648e3ad140284",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case(
        "headphones",
        "Knock the headphones over sideways",
        "hit tip",
    ),
    Case(
        "headphones",
        "Someone grabs the headband, lifts the headphones up off the floor and then lets go so they drop "
        "back down.",
        "drop lift sequence part",
    ),
    Case(
        "headphones",
        "these headphones are made of soft rubber, press them down flat from above and then let them spring "
        "back up",
        "material squeeze sequence",
    ),
    Case(
        "headphones",
        "A strong gust of wind hits them from the front and sends them sliding and tumbling across the floor",
        "hit wind sequence",
    ),
    Case(
        "windturbine",
        "the wind picks up and the three blades start spinning round faster and faster",
        "spin wind lift sequence quantity part",
    ),
    Case(
        "windturbine",
        "knock it over backwards",
        "hit tip",
    ),
    Case(
        "windturbine",
        "Lift the wind turbine straight up off the ground, then let go so it drops and topples onto its side.",
        "drop tip wind lift sequence",
    ),
    Case(
        "windturbine",
        "A really strong gust hits it from the left, the whole thing sways over to the right and then rocks "
        "back until it's standing still again",
        "hit sway wind sequence",
    ),
    Case(
        "survivor",
        "It's made of soft rubber, so drop it from about waist height and let it bounce a couple of times "
        "before it comes to rest.",
        "material drop jump",
    ),
    Case(
        "survivor",
        "a strong gust of wind knocks him flat over",
        "hit tip wind",
    ),
    Case(
        "survivor",
        "Lay the figure down on the floor first, and then squash it flat with a heavy plate from above.",
        "squeeze sequence",
    ),
    Case(
        "survivor",
        "Bend his left arm down until it hangs by his side.",
        "bend part",
    ),
    Case(
        "shovel",
        "drop the shovel from about head height",
        "drop push",
    ),
    Case(
        "shovel",
        "The shovel is made of soft rubber, so when someone picks it up by the middle and lets go it should "
        "flop onto the ground and wobble a bit.",
        "material push sway lift sequence",
    ),
    Case(
        "shovel",
        "Grab the blade and bend it upwards until it stays bent.",
        "bend part",
    ),
    Case(
        "shovel",
        "Give it a hard shove so it slides across the floor, then have it spin around a couple of times "
        "before it stops",
        "push spin sequence",
    ),
    Case(
        "smallboat",
        "tip the boat over onto its side",
        "tip",
    ),
    Case(
        "smallboat",
        "The boat is made of soft rubber, so when it gets dropped from about waist height it squashes on the "
        "floor and bounces back up.",
        "material drop jump squeeze",
    ),
    Case(
        "smallboat",
        "Someone grabs the pointed front end of the boat and lifts it up while the back stays on the ground, "
        "then lets go so it slams back down.",
        "lift sequence part",
    ),
    Case(
        "smallboat",
        "A strong gust of wind pushes the little boat across the floor, and it spins around as it slides to "
        "a stop",
        "push spin wind",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentysecond": _PAIRS}
