"""Pairs on a fourth lot of objects that nothing was developed with, written before any was run, and never changed."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

LIBIGL = "libigl/libigl-tutorial-data/c1f9ede366d02e3531ecbaec5e3769312f31cccd"
NEEDLE = "needle-tools/needle-engine-samples/a623e96180099bc7a1c494ec17157843540c68b7/package/Runtime"
FURNITURE = (
    "KayKit-Game-Assets/KayKit-Furniture-Bits-1.0/96d5930a8dbdb363409bbc2d3341718b00e17c9c"
    "/addons/kaykit_furniture_bits/Assets/obj"
)
STATUES = "playcanvas/web-components/b24c63cd22cafb1c0245149f69b80361b31f0f00/examples/assets/splats/statues"

FILES: Mapping[str, PinnedFile] = {
    "elephant": PinnedFile(
        "elephant.obj",
        LIBIGL,
        "f1038147fa61efd8b3213d119c682279ffea3cf06cc1713ae2a8ff81e68ba671",
        "mesh, libigl tutorial data; no licence is stated",
    ),
    "saxophone": PinnedFile(
        "saxophone_alto.glb",
        f"{NEEDLE}/SpatialAudio/Models",
        "169f57adc628d4d530fbed805c36146420461e2894da6fe658920cf6daedb667",
        "mesh with colours, Saxophone Alto by ANDRIANIAINAToky (skfb.ly/oDHyu); the repository's licence is MIT",
    ),
    "couch": PinnedFile(
        "couch.obj",
        FURNITURE,
        "caa5ff28b15c43b4997315183dd2cf24ab4e2a50fb890828a39ed5b4fd79f0f4",
        "mesh, Furniture Bits by Kay Lousberg (kaylousberg.com), CC0-1.0",
    ),
    "cactus": PinnedFile(
        "cactus.glb",
        f"{NEEDLE}/Physics/Assets",
        "bbb3236269eae96db7d06df6505e068c6ada1022d5ca881f1f6175e96603e370",
        "mesh with texture, Jeremy Edelblut (github.com/jeremytoys/3moji), CC-BY-SA-4.0",
    ),
    "trumpeter": PinnedFile(
        "trumpet.sog",
        STATUES,
        "5b1c7018f8445e9cb8687cdfb4ebcb85d4a9e9ca9a1ceb9f929dd060de8c6a79",
        "3DGS capture, 89,292 Gaussians, PlayCanvas web components examples; the repository's licence is MIT",
    ),
}

_OPTIONS = {  # neither an OBJ nor a SOG tells; pictures show each upright
    "elephant": ("--up", "+y"),
    "couch": ("--up", "+y"),
    "trumpeter": ("--up", "-y"),
}

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("elephant", "the elephant swings its trunk from side to side", "sway part"),
    Case("elephant", "the elephant hops twice on the spot", "jump quantity"),
    Case("elephant", "shove the elephant so that it falls on its back", "push tip"),
    Case("elephant", "squeeze a plush elephant, then let go", "squeeze material sequence"),
    Case("saxophone", "the saxophone slowly tilts to the left and falls over", "tip slight"),
    Case("saxophone", "bend the neck of the saxophone down", "bend part"),
    Case("saxophone", "a hard blow dents the bell of a brass saxophone", "hit part material violent"),
    Case("saxophone", "toss the saxophone to the right", "throw"),
    Case("couch", "push the couch to the left by half its width", "push quantity"),
    Case("couch", "press down on the seat of the couch", "squeeze part"),
    Case("couch", "lift one end of the couch and let it drop", "lift drop part sequence"),
    Case("couch", "a wooden couch falls from twice its own height", "drop material quantity"),
    Case("cactus", "the cactus sways in a gentle wind", "sway wind slight"),
    Case("cactus", "pull the right arm of the cactus down", "bend part"),
    Case("cactus", "the cactus floats up and slowly turns around", "lift spin slight"),
    Case("cactus", "squash a cactus made of clay to half its height", "squeeze material quantity"),
    Case("trumpeter", "a storm from the left blows the statue over", "wind tip violent"),
    Case("trumpeter", "turn the statue halfway around", "spin quantity"),
    Case("trumpeter", "push the statue's head forward", "push part"),
    Case("trumpeter", "the statue wobbles for a moment and then stands still", "sway stillness sequence"),
)

SETS = {"fourth": _PAIRS}
