"""Pairs on a ninth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: a language model wrote them from pictures of the objects, without the code or other sentences. The
panda looks like a monster in these, and is called one.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

GDQUEST = "gdquest-demos/godot-4-3d-third-person-controller/9fffa2947744181e05078e3e364f43dbb8a221d7"

FILES: Mapping[str, PinnedFile] = {
    "bee": PinnedFile(
        "bee_bot.glb",
        f"{GDQUEST}/Enemies/BeeBot",
        "84be7073be110bd4bc6b3a2553ac4f1d9486ef81c422f6068b76cd2ded56ccca",
        "mesh with textures, by GDQuest, CC BY 4.0",
    ),
    "monster": PinnedFile(
        "Panda.obj",
        "simondevyoutube/Quick_3D_RPG/bfeef5ccd670a1adc1d8d77da94900492e28f471/resources/monsters/OBJ",
        "2600218abb5d84c54bc59e6396bdaae0ebe115b10adb1b895b8b2589e5fbfd93",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "helicopter": PinnedFile(
        "heli.glb",
        "swift502/Sketchbook/62f4b7986fd1ce1e4f91daba89ef032c20a6ce55/build/assets",
        "1fe2a67a8881d493dbe99e1dd5319f5c958d71491161aa89dbde90c4a3d04bd7",
        "mesh, Sketchbook by swift502, MIT",
    ),
    "table": PinnedFile(
        "table_medium.obj",
        "KayKit-Game-Assets/KayKit-Prototype-Bits-1.0/bb159596f4f5106b663741d002c8eb45c80c0f41"
        "/addons/kaykit_prototype_bits/Assets/obj",
        "b1b2d90a41e71c32c824c8556ad2fa47e550f3e43ee66a296295e219a532538e",
        "mesh, Prototype Bits by Kay Lousberg (kaylousberg.com), CC0-1.0",
    ),
    "mushroom": PinnedFile(
        "mushroom.glb",
        f"{GDQUEST}/Environment/mushroom",
        "e428765c33d276680d7e5e6edbea8d8f882d7178d68583a300f45a36c8102772",
        "mesh with textures, by GDQuest, CC BY 4.0",
    ),
}

_OPTIONS = {
    "monster": ("--up", "+y"),
    "table": ("--up", "+y"),
}  # the files do not tell; pictures show each upright

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("bee", "The bee's wings flap quickly up and down.", "part sway"),
    Case("bee", "The bee lifts into the air and then drops to the ground.", "sequence lift drop"),
    Case("bee", "A strong wind blows the bee over.", "wind tip violent"),
    Case("bee", "A rubber bee bounces on the floor.", "material drop"),
    Case("monster", "The monster wiggles its ears a little.", "part sway slight"),
    Case("monster", "The monster is made of jelly and wobbles when it lands.", "material drop sway"),
    Case("monster", "The monster gets hit hard from the side and goes flying.", "hit throw violent"),
    Case("monster", "Slowly stretch the monster until it's tall and thin.", "stretch"),
    Case("helicopter", "The big blades on top of the helicopter spin really fast.", "part spin"),
    Case(
        "helicopter",
        "The helicopter takes off and then crashes into the ground.",
        "sequence lift drop violent",
    ),
    Case("helicopter", "Turn the helicopter 90 degrees to the left.", "quantity spin"),
    Case("helicopter", "The helicopter slowly tips over onto its side.", "tip"),
    Case("table", "One of the table's legs slowly bends.", "part bend"),
    Case("table", "The table is made of wood and falls from one meter up.", "material quantity drop"),
    Case("table", "Push the table gently across the floor.", "push slight"),
    Case("table", "The table shakes hard like there's an earthquake.", "sway violent"),
    Case("mushroom", "The mushroom's cap sways gently from side to side.", "part sway slight"),
    Case("mushroom", "The mushroom jumps up and down three times.", "quantity jump"),
    Case("mushroom", "The mushroom tips over and then rolls away.", "sequence tip roll"),
    Case("mushroom", "A foam mushroom gets squeezed between two walls.", "material squeeze"),
)

SETS = {"ninth": _PAIRS}
