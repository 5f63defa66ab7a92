"""Pairs on a twelfth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: language models wrote them from pictures of the objects, without the code or other sentences. The
yeti is of the family of the ninth lot's monster. The drone is called a robot in these, the yeti a monster.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

QUATERNIUS = "simondevyoutube/Quick_3D_RPG/bfeef5ccd670a1adc1d8d77da94900492e28f471/resources"
KAYKIT = "sketchpunklabs/kaykit_halloween/f56e5550152fe24625373929dbb1a5c327f49ef3/assets"

FILES: Mapping[str, PinnedFile] = {
    "yeti": PinnedFile(
        "Yeti.obj",
        f"{QUATERNIUS}/monsters/OBJ",
        "0b0a8a17e398a3957514d6f6c3f222618e98cb6de10c80c9a9487af680780d27",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "drone": PinnedFile(
        "enemy-flying.glb",
        "KenneyNL/Starter-Kit-FPS/cc46ba7b2b14275916429df7fdf7692f431902f2/models",
        "e4868f6d8cac2a8f728430229789206841ca64727d94de2d808b468e4f182f8c",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
    ),
    "pine": PinnedFile(
        "PineTree_2.obj",
        f"{QUATERNIUS}/nature/OBJ",
        "55c3b088118577df7cd363094c49b499058b022a39ad7e8434cb11e40dee0771",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "skeleton": PinnedFile(
        "character_skeleton_minion.gltf",
        f"{KAYKIT}/skeletons",
        "8b983d51d8dd308c429ffd40769906752304afdba5a73fdca53d8df8b0b90391",
        "mesh, by Kay Lousberg (kaylousberg.com), CC0-1.0",
    ),
    "cauldron": PinnedFile(
        "cauldron.gltf.glb",
        f"{KAYKIT}/spooktober",
        "441fb37a6c588ffb8e77123d12e311cce307c7af538d6b1ca06a3f69ff598af3",
        "mesh, by Kay Lousberg (kaylousberg.com), CC0-1.0",
    ),
}

# These files do not tell; their pictures show them upright.
THINGS = pin_things(FILES, dict.fromkeys(("yeti", "pine"), ("--up", "+y")))

_PAIRS = (
    Case("yeti", "someone flicks the monster's horns and they wobble", "part hit sway"),
    Case("yeti", "The monster head is made of jelly and drops onto the floor", "material drop"),
    Case("yeti", "the monster jumps up twice and then rolls onto its back", "sequence quantity jump roll"),
    Case("yeti", "A heavy plate slowly squashes the monster flat.", "squeeze"),
    Case("drone", "The robot's head turns 90 degrees to the left", "part quantity twist"),
    Case("drone", "strong wind shoves the robot backwards across the floor", "wind push violent"),
    Case("drone", "The robot falls from high up and crashes onto its side.", "drop violent"),
    Case("drone", "give the robot a gentle nudge from behind", "push slight"),
    Case("pine", "The tree sways in a light breeze.", "wind sway slight"),
    Case("pine", "the tip of the tree slowly droops down to one side", "part bend"),
    Case("pine", "A rubber tree gets twisted and then springs back", "material sequence twist"),
    Case("pine", "The tree gets hit really hard and topples over.", "hit tip violent"),
    Case("skeleton", "The skeleton's big head bobbles back and forth", "part sway"),
    Case("skeleton", "the little skeleton spins around three times on the spot", "spin quantity"),
    Case("skeleton", "Throw the skeleton against a wall!", "throw violent"),
    Case("skeleton", "The skeleton is made of soft clay and gets squashed from above.", "material squeeze"),
    Case("cauldron", "The pot is made of solid iron and lands with a heavy thud", "material drop"),
    Case("cauldron", "the cauldron tips over and then rolls away", "sequence tip roll"),
    Case("cauldron", "The legs of the cauldron buckle under its weight", "part bend"),
    Case("cauldron", "The cauldron shakes and rattles like it's boiling over.", "sway"),
)

SETS = {"twelfth": _PAIRS}
