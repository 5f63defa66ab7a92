"""Pairs on a tenth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: a language model wrote them from pictures of the objects, without the code or other sentences. The
chicken looks like a bird in these, and is called one.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

GDQUEST = "gdquest-demos/godot-4-3d-third-person-controller/9fffa2947744181e05078e3e364f43dbb8a221d7"

FILES: Mapping[str, PinnedFile] = {
    "bird": PinnedFile(
        "Chicken.obj",
        "simondevyoutube/Quick_3D_RPG/bfeef5ccd670a1adc1d8d77da94900492e28f471/resources/monsters/OBJ",
        "36d7b89b452bfd008e4d7bc79e9740d32cd14c07eaf2701b77583206a0fcd75d",
        "mesh, by Quaternius, CC0-1.0",
    ),
    "gdbot": PinnedFile(
        "gdbot.glb",
        f"{GDQUEST}/Player/model",
        "cdeca527d5672d0c402362e7b6bdfac35a091096ad504b3bd51d8fa49817025f",
        "mesh with textures, by GDQuest, CC BY 4.0",
    ),
    "pickup": PinnedFile(
        "vehicle-truck-red.glb",
        "KenneyNL/Starter-Kit-Racing/2f2e5f2646dda89cb21d4e8539bab60c6e955dc8/models",
        "eca99bd9ab0a2b02125f915e65d1ec8f1c5a93be7c6d4840efdac6633f47772c",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
    ),
    "flag": PinnedFile(
        "flag.glb",
        "KenneyNL/Starter-Kit-3D-Platformer/3fa8a04b1c01ab23db43123d4ce814a34c3fc7f0/models",
        "0ba84ff43f0fea0a9f0b080cfa1be54ebda36c8c35174d1ac2553ae6da9f65ae",
        "mesh, by Kenney (kenney.nl), CC0-1.0",
    ),
    "flower": PinnedFile(
        "orange_flower.glb",
        f"{GDQUEST}/Environment/orange_flowers",
        "049ad9edb969e625b0247d8a85edf6e8434c1463bab21b35f889c96f8d3ed110",
        "mesh with textures, by GDQuest, CC BY 4.0",
    ),
}

THINGS = pin_things(FILES, {"bird": ("--up", "+y")})  # the file does not tell; its picture shows it upright

_PAIRS = (
    Case("bird", "The bird flaps both its wings up and down.", "part sway"),
    Case("bird", "The bird is made of jelly and wobbles after falling on the floor.", "material drop sway"),
    Case("bird", "The bird hops twice and then falls flat on its face.", "sequence quantity jump tip"),
    Case("bird", "Something flat slowly squashes the bird down from above.", "squeeze"),
    Case("gdbot", "The robot slowly lifts its left arm above its head.", "part lift"),
    Case("gdbot", "The robot gets shoved hard from the front and lands on its back.", "push tip violent"),
    Case("gdbot", "The robot jumps up and then spins around on the floor.", "sequence jump spin"),
    Case("gdbot", "The robot sways a little in a light wind.", "wind sway slight"),
    Case("pickup", "The truck's wheels spin but the truck doesn't move.", "part spin stillness"),
    Case("pickup", "A rubber truck drops from two meters up and bounces.", "material quantity drop"),
    Case("pickup", "The truck gets thrown at a wall and crashes into it.", "throw hit violent"),
    Case("pickup", "Give the truck a gentle push so it rolls forward.", "push roll slight"),
    Case("flag", "The cloth is made of silk and flutters in a gentle breeze", "part material wind slight"),
    Case("flag", "A hard shove from the side knocks the flag over", "push tip violent"),
    Case("flag", "The flag sways back and forth and then stands still", "sequence sway stillness"),
    Case("flag", "The flag spins around three times", "quantity spin"),
    Case("flower", "A rubber flower falls from above and bounces on the floor", "material drop"),
    Case("flower", "The orange petals slowly fold up toward the middle", "part bend"),
    Case("flower", "The flower hops into the air and then gets squashed flat", "sequence jump squeeze"),
    Case("flower", "A strong gust of wind blows the flower away", "wind violent"),
)

SETS = {"tenth": _PAIRS}
