"""Pairs on a sixth lot of objects that nothing was developed with, written before any was run, and never changed.

A language model wrote them that had seen pictures of the objects, and neither the code nor the sentences before: what
most people would try first, with a part in a quarter of them and a material in a fifth, as among the sixty.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.held_back.fourth import LIBIGL, NEEDLE, STATUES
from benchmarks.first_results.pins import PinnedFile

FILES: Mapping[str, PinnedFile] = {
    "horse": PinnedFile(
        "horse_quad.obj",
        LIBIGL,
        "f266409b006dd339125dab91c3ca6aefe7289a03c7cf5848b985fcb19ae3de93",
        "mesh, libigl tutorial data; no licence is stated",
    ),
    "laptop": PinnedFile(
        "Laptop.glb",
        f"{NEEDLE}/Configurator/Content/Laptop/Models",
        "b55c550e806a16b306546ecbaa54f36af0e8636a151097000add874e5452a9d0",
        "mesh, Needle Engine samples; the repository's licence is MIT",
    ),
    "toyrobot": PinnedFile(
        "Robot.glb",
        f"{NEEDLE}/USDZExport/Models",
        "e0acac424c2c637e7e6812ae5d1f0708643ef702446c6b8369bf8de45a6e1fce",
        "mesh, Needle Engine samples; the repository's licence is MIT",
    ),
    "grinder": PinnedFile(
        "coffee_grinder.glb",
        f"{NEEDLE}/ProductFlyover/Assets",
        "78e1eded73d1437ed3369bfbd28a333d406021972d05989c2a568ba599b26081",
        "mesh with texture, Needle Engine samples; the repository's licence is MIT",
    ),
    "kneeler": PinnedFile(
        "angel-kneeling.sog",
        STATUES,
        "ce8fd6d1b66433932f3aa3f54fd9bc204ee2f3add2a792af62244d6f137a6ea8",
        "3DGS capture, PlayCanvas web components examples; the repository's licence is MIT",
    ),
}

_OPTIONS = {
    "horse": ("--up", "+y"),
    "kneeler": ("--up", "-y"),
}  # the files do not tell; pictures show each upright

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("horse", "Push the horse over onto its side", "push tip"),
    Case("horse", "Bend the horse's head down to the ground", "bend part"),
    Case("horse", "Shake the horse as if it were made of jelly", "sway material"),
    Case("horse", "The horse jumps up and then lands back on its feet", "jump sequence"),
    Case("laptop", "Close the laptop screen", "bend part"),
    Case("laptop", "Spin the laptop 180 degrees on the floor", "spin quantity"),
    Case("laptop", "Throw the laptop hard to the right", "throw violent"),
    Case("laptop", "Lift the laptop up and then drop it", "lift drop sequence"),
    Case("toyrobot", "Lift the robot's arms up", "lift part"),
    Case("toyrobot", "Squash the robot flat as if it were made of clay", "squeeze material"),
    Case("toyrobot", "Make the robot hop three times", "jump quantity"),
    Case("toyrobot", "Gently push the robot so it wobbles but stays standing", "push sway slight"),
    Case("grinder", "Turn the crank handle on top of the coffee grinder", "spin part"),
    Case("grinder", "The grinder is made of rubber and bounces on the floor", "drop material"),
    Case("grinder", "Drop the coffee grinder from one meter high", "drop quantity"),
    Case("grinder", "Knock the grinder over and then roll it away", "hit tip roll sequence"),
    Case("kneeler", "A strong wind blows the angel statue over", "wind tip violent"),
    Case("kneeler", "Stretch the angel's wings out as if they were rubber", "stretch part material"),
    Case("kneeler", "Rock the statue side to side and then let it stand still", "sway sequence stillness"),
    Case("kneeler", "Slowly twist the whole statue", "twist"),
)

SETS = {"sixth": _PAIRS}
