"""Pairs on a nineteenth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET, QUATERNIUS
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "tallalien": PinnedFile(
        "Alien_Tall.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "1ac9f0ff3f1de0423ae9b2fef7b0dc2a0e3fe481b6b544b9ac0ab739decc9419",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "garbagetruck": PinnedFile(
        "garbage-truck.gltf",
        f"{MARKET}/garbage-truck",
        "d8d4b822458c9732de9b702e291f0a13a3c9747332d4efe5a1fd39e698f48112",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "skaterboy": PinnedFile(
        "skater-male.gltf",
        f"{MARKET}/skater-male",
        "7bf4ba6916e00fc8ba8c04b181fd12223d71cf80b2199144ba8a081aca7f43ec",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "sundae": PinnedFile(
        "sundae.gltf",
        f"{MARKET}/sundae",
        "d2581d4e91d3f97277b60e8273478558996b53b87f463b6b1b069c966802471d",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "turkey": PinnedFile(
        "turkey.gltf",
        f"{MARKET}/turkey",
        "e767b81bc888c60ab90fbfa36323dfb87b6ba1e4197ad6f639405545453b83d9",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {"tallalien": ("--up", "+y")})

_PAIRS = (
    Case(
        "tallalien",
        "Twist top half a quarter turn left, base stays put.",
        "twist part quantity space stillness",
    ),
    Case(
        "tallalien",
        "Hi there, could you please have a hand gently press down on the little knob on top of its "
        "head so the whole monster squashes just a tiny bit, and then it wobbles back up once the "
        "hand goes away?",
        "push squeeze sway part slight sequence",
    ),
    Case(
        "tallalien",
        "make it outta plasticine n drop it from rly high up so it goes splat on teh floor lol",
        "drop material violent",
    ),
    Case(
        "tallalien",
        "A ball coming from the left edge of the picture hits the left arm, which bends in towards "
        "the body, and the body tips about 15 degrees to the right before rocking back and coming "
        "to rest upright.",
        "hit bend tip part quantity space sequence stillness",
    ),
    Case(
        "garbagetruck",
        "Front lifting arms get yanked up, then let go so they spring back.",
        "bend part sequence",
    ),
    Case(
        "garbagetruck",
        "Hi there, could you please pretend the garbage truck is made of soft foam rubber and show "
        "me a big hand pressing down gently on its roof, so that it squishes just a little bit?",
        "squeeze material part slight",
    ),
    Case(
        "garbagetruck",
        "make a realy crazy strong wind come from teh left n knock the truck over on its side lol",
        "wind tip violent space",
    ),
    Case(
        "garbagetruck",
        "Raise the truck straight up by half of its own height, hold it motionless for one second, "
        "and then release it so that it falls back onto the ground.",
        "lift drop sequence stillness quantity",
    ),
    Case(
        "skaterboy",
        "Bend his left arm down, then let it spring back.",
        "bend part sequence",
    ),
    Case(
        "skaterboy",
        "Hi there, could you please make the boy's big head wobble gently from side to side, as if "
        "it were made of soft rubber, while his sneakers stay planted on the floor?",
        "sway part slight material stillness",
    ),
    Case(
        "skaterboy",
        "lol chuck a ball realy hard at his chest so he topples over backwards",
        "hit throw tip violent part",
    ),
    Case(
        "skaterboy",
        "A hand lifts the figure about half a metre off the ground by the top of its head, holds "
        "it there for one second, and then releases it so that it lands on its shoes and falls "
        "over onto its right side.",
        "lift part quantity space stillness drop tip sequence",
    ),
    Case(
        "sundae",
        "Strong gust from the left topples the sundae.",
        "wind tip violent space",
    ),
    Case(
        "sundae",
        "Hi, could you please pretend the whole sundae is made of soft jelly and let a hand nudge "
        "it gently from the right, so that it wobbles a bit and then comes to rest still standing?",
        "material push slight sway sequence stillness space",
    ),
    Case(
        "sundae",
        "grab the cherry on top n pull it strait up so the hole thing strechs, then let go and "
        "watch it snap bakc lol",
        "part stretch sequence space",
    ),
    Case(
        "sundae",
        "Lift the sundae to one and a half times its own height above the ground, tilt it 30 "
        "degrees toward the camera, and then drop it so that it lands on the edge of its base, "
        "tips over and rolls onto its side.",
        "lift drop sequence quantity space part tip roll",
    ),
    Case(
        "turkey",
        "Tip it over onto its side.",
        "tip roll",
    ),
    Case(
        "turkey",
        "Hi, could you please have a hand gently pull one of the leg bones out to the left and "
        "then let go, so that I can watch the whole turkey wobble a little?",
        "stretch bend sway sequence part slight space",
    ),
    Case(
        "turkey",
        "make teh turkey outta jelly n drop it from way up high so it bounces n jiggels like crazy lol",
        "drop jump sway squeeze material violent space",
    ),
    Case(
        "turkey",
        "A ball strikes the roast from the right at 3 m/s, and the roast then slides about half of "
        "its own length to the left until it comes to rest against a wall.",
        "hit push sequence quantity space wall stillness",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"nineteenth": _PAIRS}
