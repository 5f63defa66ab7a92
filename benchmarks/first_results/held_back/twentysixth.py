"""Pairs on a twenty-sixth lot of objects that nothing was developed with, written before any was run.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.thirteenth import MARKET
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "bicycle": PinnedFile(
        "bike.gltf",
        f"{MARKET}/bike",
        "3ca8d42a745f8c42ea49f2362fcdb1f669b5a9a4c4f2b02c2ce4ba5c1fab08a5",
        "mesh, by hugodutra, CC0-1.0",
        "model.gltf",
    ),
    "dogue": PinnedFile(
        "dogue.gltf",
        f"{MARKET}/dogue",
        "be967def8532415ccfee25b7708dba5678c297ed044bd5398e9fcac2ca0fa816",
        "mesh, by Reuben Sotomayor and Alejandro León, CC0-1.0",
        "model.gltf",
    ),
    "peppermill": PinnedFile(
        "pepper-mill.gltf",
        f"{MARKET}/pepper-mill",
        "0976466f3a33bfca078ed6e6c78a6ff3bb155b88b220edc4ec151237abc502ee",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
    "keyboard": PinnedFile(
        "mechanical-keyboard.gltf",
        f"{MARKET}/mechanical-keyboard",
        "0a30d51e77cf9a656b1f745534f2c358c096a414fe91a4eaa5259d38c2d9fd37",
        "mesh, by NotDaisuke (blendswap.com), CC-BY",
        "model.gltf",
    ),
    "plainpumpkin": PinnedFile(
        "pumpkin.gltf",
        f"{MARKET}/pumpkin",
        "b79f85c04450c03ccd004693dfebce74ea0201215eaef81952d71551e8d18e82",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
        "model.gltf",
    ),
}

# The file does not tell; its pictures show it upright.
THINGS = pin_things(FILES, {})

_PAIRS = (
    Case(
        "bicycle",
        "bike rides forward by itself",
        "push",
    ),
    Case(
        "bicycle",
        "Turn the handlebars all the way to the left, then back to straight, with the front wheel "
        "turning along with them.",
        "spin sequence part",
    ),
    Case(
        "bicycle",
        "make it out of floppy rubber!! like a hand pushes down hard on the seat and the whole "
        "frame sags in the middle and then boings back up",
        "material push sequence",
    ),
    Case(
        "bicycle",
        "The bike does a wheelie, lifting its front wheel high off the ground and balancing on the "
        "back wheel for a second, and after the front wheel drops back down it slowly tips over and"
        " falls flat on its side on the floor.",
        "drop tip lift sequence",
    ),
    Case(
        "dogue",
        "make the dog run in a circle",
        "push",
    ),
    Case(
        "dogue",
        "I'd love to see his curly tail wag really fast from side to side, so hard that his bum "
        "wiggles along with it.",
        "sway part",
    ),
    Case(
        "dogue",
        "doggo is made of wobbly jelly and a big hand pokes him in the side, he jiggles all over lol",
        "material sway",
    ),
    Case(
        "dogue",
        "The dog first sits down on its hind legs and tilts its head to the left as if it is "
        "listening to something, and then it jumps straight up into the air and lands back on all "
        "four paws.",
        "jump sequence",
    ),
    Case(
        "peppermill",
        "it tips over and rolls away",
        "tip roll",
    ),
    Case(
        "peppermill",
        "The round knob on top should twist around a few times, like somebody is grinding pepper, "
        "while the rest stays still.",
        "twist part",
    ),
    Case(
        "peppermill",
        "make it out of really squishy rubber and have a hand push it down from above till its all "
        "squashed, then let go so it boings back up",
        "material squeeze push sequence",
    ),
    Case(
        "peppermill",
        "I'd like the pepper mill to wobble from side to side on its base as if it were about to "
        "fall, getting wilder and wilder, and after that it jumps up high, does one full somersault"
        " in the air and lands standing upright again.",
        "drop jump sway sequence",
    ),
    Case(
        "keyboard",
        "flip the keyboard upside down",
        "spin",
    ),
    Case(
        "keyboard",
        "The cable at the back whips around like an angry snake while the rest of the keyboard "
        "stays where it is.",
        "part",
    ),
    Case(
        "keyboard",
        "make it out of soft wobbly jelly and have a hand slap down on the middle so the whole "
        "thing jiggles and all the keys shake",
        "material sway",
    ),
    Case(
        "keyboard",
        "First the keys get pressed down one after another from left to right, like a wave running "
        "across the keyboard, and then the whole keyboard stands up on its short side and topples "
        "over flat onto the floor with a little bounce.",
        "jump tip squeeze sequence",
    ),
    Case(
        "plainpumpkin",
        "pumpkin rolls away across the floor",
        "roll",
    ),
    Case(
        "plainpumpkin",
        "I'd like the little green stem on top to bend over slowly to one side and then spring back"
        " up, while the pumpkin itself stays put.",
        "bend sequence part",
    ),
    Case(
        "plainpumpkin",
        "make it out of jelly and a hand slaps it on the side so the whole thing wobbles like crazy!!",
        "material sway",
    ),
    Case(
        "plainpumpkin",
        "The pumpkin drops from high up and smashes on the ground, splitting into its four big "
        "chunks that tumble apart, and after a moment the chunks slide back together and it's a "
        "whole pumpkin again.",
        "drop push hit sequence",
    ),
)

SETS: Mapping[str, tuple[Case, ...]] = {"twentysixth": _PAIRS}
