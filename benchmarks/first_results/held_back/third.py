"""Pairs on yet another five objects that nothing was developed with, written before any was run, and never changed."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.sixty import BABYLON, MESHES
from benchmarks.first_results.pins import PinnedFile

KAYKIT = "KayKit-Game-Assets"
STATUES = "playcanvas/web-components/b24c63cd22cafb1c0245149f69b80361b31f0f00/examples/assets/splats/statues"

FILES: Mapping[str, PinnedFile] = {
    "seagull": PinnedFile(
        "seagulf.glb",
        BABYLON,
        "ea8fa94222cf4ed70b2b56369ef7bcc640ab60f3b18177e8180aca5e0be84102",
        "mesh with texture, Babylon.js meshes library, CC-BY-4.0",
    ),
    "lander": PinnedFile(
        "lander_A.obj",
        f"{KAYKIT}/KayKit-Space-Base-Bits-1.0/6dfbcac9927d06283752c4defd4882cfe0d29666"
        "/addons/kaykit_space_base_bits/Assets/obj",
        "84e12fffe86d21a1dc8b675dd314d9b4f1373701fcc84bd6ea26366c23d34abd",
        "mesh, Space Base Bits by Kay Lousberg (kaylousberg.com), CC0-1.0",
    ),
    "lamp": PinnedFile(
        "lamp_standing.obj",
        f"{KAYKIT}/KayKit-Furniture-Bits-1.0/96d5930a8dbdb363409bbc2d3341718b00e17c9c"
        "/addons/kaykit_furniture_bits/Assets/obj",
        "81d8bb8266ea51fc17d577d4eba8435de10716ac8f8555a66b8018125de79e6e",
        "mesh, Furniture Bits by Kay Lousberg (kaylousberg.com), CC0-1.0",
    ),
    "pizza": PinnedFile(
        "pizza.obj",
        f"{MESHES}/pizza",
        "69bb558e9d1ccbc4214c761b3a95171e98d750896353e9fea57a056917425392",
        "mesh, a scan by Rigsters, CC-BY-4.0, modified",
    ),
    "statue": PinnedFile(
        "narcissus.sog",
        STATUES,
        "98adf17789c3850efc0224542816ed058590dce9545a1a65a76b938815b97236",
        "3DGS capture, 101,275 Gaussians, PlayCanvas web components examples; the repository's licence is MIT",
    ),
}

_OPTIONS = {  # neither an OBJ nor a SOG tells; pictures show each upright
    "lander": ("--up", "+y"),
    "lamp": ("--up", "+y"),
    "pizza": ("--up", "+y"),
    "statue": ("--up", "-y"),
}

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("seagull", "the seagull nods its head", "sway part"),
    Case("seagull", "the seagull hops to the left, then stands still", "jump stillness sequence"),
    Case("seagull", "a gust from behind knocks the seagull flat on its face", "wind tip"),
    Case("seagull", "someone tugs the seagull's tail upwards", "push part"),
    Case("lander", "the lander rises straight up to twice its own height and stays there", "lift quantity"),
    Case("lander", "the dish on top of the lander turns around", "spin part"),
    Case("lander", "one of the lander's legs gets bent inwards", "bend part"),
    Case("lander", "crumple a lander made of tin foil", "squeeze material"),
    Case("lamp", "the floor lamp teeters, then crashes to the floor", "sway tip sequence"),
    Case("lamp", "knock the shade of the lamp to the right", "hit part"),
    Case("lamp", "bend the pole of the lamp by about 45 degrees", "bend part quantity"),
    Case("lamp", "twist a floor lamp made of rubber, then let it spring back", "twist material sequence"),
    Case("pizza", "fold the pizza in half", "bend"),
    Case("pizza", "toss the pizza into the air so that it spins and falls back down", "throw spin sequence"),
    Case("pizza", "lift the crust on one side of the pizza", "lift part"),
    Case("pizza", "stretch a pizza of soft dough a little wider", "stretch material slight"),
    Case("statue", "slide the statue a third of its height to the right", "push quantity"),
    Case("statue", "the statue lowers its raised arm", "bend part"),
    Case("statue", "the marble statue rocks back and forth but doesn't fall", "sway material"),
    Case("statue", "an earthquake shakes the statue until it topples", "sway tip violent sequence"),
)

SETS = {"third": _PAIRS}
