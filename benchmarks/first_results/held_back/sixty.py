"""Pairs on objects that nothing was developed with. They were written before any was run, and are never changed."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

MESHES = "odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects"
COMMON = "alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202/data"
TRIMESH = "mikedh/trimesh/a513c0e2cfa6dfbd3121a6dfd8ceb002b9ef55d8/models"
PLAYCANVAS = "playcanvas/engine/0aaef5e432c4797ed23c1f966e2cc43232ec0613/examples/assets"
BABYLON = "BabylonJS/MeshesLibrary/1e0c5cdbdfec7b632b9aa1f498f7016b0d210779"


def _mesh(name: str, sha256: str, credit: str, file: str = "") -> PinnedFile:
    return PinnedFile(f"{file or name}.obj", f"{MESHES}/{name}", sha256, f"mesh, {credit}")


FILES: Mapping[str, PinnedFile] = {
    "teapot": PinnedFile(
        "teapot.obj",
        COMMON,
        "1b5396fedd74b577e32cef41146582c2f2e1a050d5b4915193c0ac1ad4187ed4",
        "mesh, the Utah teapot by Martin Newell; no licence is stated",
    ),
    "armadillo": _mesh(
        "armadillo",
        "17200138dad1ad0f86ef9a98dd38f9932098b2c9e94d8694bd3f6143601e8c54",
        "Stanford 3D Scanning Repository (research use, with credit)",
    ),
    "duck": PinnedFile(
        "Duck.glb",
        TRIMESH,
        "65bf938f54d6073e619e76e007820bbf980cdc3dc0daec0d94830ffc4ae54ab5",
        "glTF sample with texture, Sony Computer Entertainment, SCEA Shared Source License 1.0",
    ),
    "penguin": _mesh(
        "penguin", "ff6c992f97ea34c1a1f6a9477a2bcd68148a60fae68797d85765f7730d5ee9f2", "Oded Stein, CC-BY-4.0"
    ),
    "koala": _mesh(
        "koala",
        "0a2b09aa89a45574ab08674479ac343f3452a7813beb66af24989a5bfcc396d7",
        "YahooJAPAN (thingiverse.com/thing:182225), CC-BY-3.0, remeshed",
        "koala_low_resolution",
    ),
    "cat": _mesh(
        "cat",
        "543b94dfe485d6f0661111b9fc063d627b11d24898f07ff6fd91e25211bbbfc7",
        "billyd (thingiverse.com/thing:1565405), CC-BY-4.0, remeshed",
        "cat-low-resolution",
    ),
    "hand": _mesh(
        "hand",
        "cb2fb353cca21db7b9dcdef96e3fc01dc42489c24b69c64c1ea0a0741d16edc4",
        "Max Planck Society e.V via SMPL, CC-BY-4.0, cropped",
        "hand_closed",
    ),
    "fish": _mesh(
        "fish",
        "9fb9b91389918ac8fddd11a44ca2d35350e200f92a2151b4e892841e49aaa158",
        "Blub by Keenan Crane, public domain",
    ),
    "hammer": _mesh(
        "hammer",
        "6afd245b8cf79768c4e7eca5b960119a476dc0a857f978d73dda94eb1279b723",
        "a scan by Andrea Spognetta (Spogna), CC-BY-4.0, modified",
    ),
    "boot": _mesh(
        "boot",
        "d2337237da8cabc6584e1ea552cb334fea3122e372198508e3b6bbbc874eefa3",
        "a scan by inciprocal, CC-BY-4.0, modified",
    ),
    "plane": _mesh(
        "plane",
        "cdf398872bd22c86a12ac65265aef1ea939af4332f8d259219fe7ea5a1cf272c",
        "YahooJAPAN (thingiverse.com/thing:182252), CC-BY-3.0",
    ),
    "man": _mesh(
        "human",
        "bad29482ce08f737912f544e3b1bef030a180e5e2efa211753a0b6a6606cab41",
        "Max Planck Society e.V via SMPL, CC-BY-4.0",
        "human_man",
    ),
    "scorpion": _mesh(
        "scorpion",
        "ff41ba38645c494a0efba53edf86d5b98be00d748c28baa38302036c1882aef2",
        "YahooJAPAN (thingiverse.com/thing:182363), CC-BY-3.0, remeshed",
        "scorpion_low_resolution",
    ),
    "monkey": PinnedFile(
        "monkey.glb",
        TRIMESH,
        "9e433ba636c830ac97a4cc5282374caca57836cc76e5b4f8bc3377344965f3a9",
        "mesh, Suzanne of Blender; no licence is stated, the repository's is MIT",
    ),
    "truck": PinnedFile(
        "CesiumMilkTruck.glb",
        TRIMESH,
        "2f17d0f4f48f23cf9d6c8d117e8f5a9ab3e2374dfd8b2e207506438c2c0b0b84",
        "glTF sample with texture, Cesium, CC-BY-4.0 (with trademark limitations)",
    ),
    "tree": PinnedFile(
        "low-poly-tree.glb",
        f"{PLAYCANVAS}/models",
        "900823c68fe9d297c71d29cf628b74ec07bf512feb752c6c0fccc3352e590980",
        "mesh with colours, sketchfab.com (4e2589134f2442bcbdab51c1f306cd58), CC-BY-4.0",
    ),
    "biker": PinnedFile(
        "biker.spz",
        f"{PLAYCANVAS}/splats",
        "21bd6d6e1b01cf6ce488db05fa76d6ba3ca2ce395fb1406fc548bc8d81fc4725",
        "3DGS capture, 152,746 Gaussians, PlayCanvas engine examples, MIT",
    ),
    "chair": PinnedFile(
        "Chair.obj",
        f"{BABYLON}/Chair",
        "c4ac14dd2a1207c98b575fd1f5fbf723ce1c24e17fac3e73737a4d28a26cc0d6",
        "mesh, Babylon.js meshes library, CC-BY-4.0",
    ),
    "goat": _mesh(
        "goathead",
        "b0aa414ce3c46e5e30ee506261f1e3cb85025e2a33b5b18bc638b08a7c57a6cb",
        "hugoelec (thingiverse.com/thing:42256), CC-BY-3.0, remeshed",
    ),
    "barrel": PinnedFile(
        "ExplodingBarrel.glb",
        BABYLON,
        "2e46b67ce14853e840d09b612f60920ff30a2719fccb561d7bd641a9054f26eb",
        "mesh with texture, Babylon.js meshes library, CC-BY-4.0",
    ),
    "cannon": PinnedFile(
        "cannon.glb",
        f"{BABYLON}/pirateFort",
        "9ea657aaf224eb097fd01091ad4e3a3d9b84e7736f2401c17cd78155c23a6461",
        "mesh with colours, Babylon.js meshes library, CC-BY-4.0",
    ),
    "lumberjack": PinnedFile(
        "lumberjack.glb",
        f"{PLAYCANVAS}/vat",
        "ff946e84edc3d810c098a034a553580c2efa852e3d146343c110b6fc6a0d04d5",
        "mesh with texture, Low Poly Lumberjack by Daz (sketchfab.com/Darren.Hogan), CC-BY-4.0",
    ),
    "bust": _mesh(
        "nefertiti",
        "3ae65c1ec016d2903af36e2fff43c8dd7cd982cec45ce09fc57f18a5ee1c3ffb",
        "the bust of Nefertiti by Nora Al-Badri and Jan Nikolai Nelles, public domain, simplified",
        "nefertiti-lowres",
    ),
}

_OPTIONS = {"plane": ("--up", "+z")}  # a preview shows it standing on a wing

THINGS = pin_things(FILES, _OPTIONS)

_SIXTY = (
    Case("teapot", "tip the teapot over to the right", "tip"),
    Case("teapot", "pull the teapot's spout to the right", "push part"),
    Case("teapot", "a teapot made of rubber falls on the floor and bounces", "drop material"),
    Case("teapot", "lift the teapot by its handle", "lift part"),
    Case("armadillo", "the armadillo jumps up and lands again", "jump"),
    Case("armadillo", "pull the armadillo's right arm down", "push part"),
    Case("armadillo", "knock the armadillo over backwards", "hit tip"),
    Case("duck", "squeeze the rubber duck and let go", "squeeze material"),
    Case("duck", "the duck rocks gently from side to side", "sway slight"),
    Case("duck", "pull the duck's head up", "stretch part"),
    Case("penguin", "the penguin sways from side to side", "sway"),
    Case("penguin", "a gust of wind topples the penguin", "wind tip"),
    Case("penguin", "lift the penguin's left wing", "lift part"),
    Case("penguin", "a penguin made of jelly wobbles", "sway material"),
    Case("koala", "push the koala forward", "push"),
    Case("koala", "pull the koala's ears up", "stretch part"),
    Case("koala", "a koala made of snow falls to the ground", "drop material"),
    Case("cat", "bend the cat's tail to the left", "bend part"),
    Case("cat", "the cat's tail sways slowly to and fro", "sway part"),
    Case("cat", "throw the cat up into the air", "throw"),
    Case("cat", "a bronze cat falls to the ground", "drop material"),
    Case("hand", "bend the fingers back", "bend part"),
    Case("hand", "push the thumb down", "push part"),
    Case("hand", "a wooden hand is knocked over", "hit tip material"),
    Case("fish", "the fish wags its tail", "sway part"),
    Case("fish", "the fish floats slowly upwards", "lift slight"),
    Case("fish", "throw the fish to the left", "throw"),
    Case("hammer", "the hammer spins around on the ground", "spin"),
    Case("hammer", "a steel hammer falls on the floor", "drop material"),
    Case("hammer", "lift the hammer by the end of its handle", "lift part"),
    Case("boot", "kick the leather boot to the right", "hit material"),
    Case("boot", "twist the boot", "twist"),
    Case("boot", "press down on the toe of the boot", "squeeze part"),
    Case("plane", "the plane takes off and flies to the right", "push lift"),
    Case("plane", "bend the wings of the plane upwards", "bend part"),
    Case("plane", "the plane slowly rolls over in the air", "roll spin slight"),
    Case("plane", "hit the tail of the plane from the left", "hit part"),
    Case("man", "the man falls over forwards", "tip"),
    Case("man", "pull the man's right arm up", "push part"),
    Case("man", "stretch a man made of rubber until he is taller", "stretch material"),
    Case("man", "shove the man hard to the left", "push violent"),
    Case("scorpion", "pull the scorpion's tail to the right", "push part"),
    Case("scorpion", "shake the scorpion", "sway"),
    Case("scorpion", "flip the scorpion onto its back", "tip"),
    Case("monkey", "squash a monkey head made of clay", "squeeze material"),
    Case("monkey", "pull both ears of the monkey outwards", "stretch part"),
    Case("monkey", "roll the monkey head to the left", "roll"),
    Case("truck", "the truck drives forward", "push"),
    Case("truck", "a heavy blow dents the roof of the truck", "hit part"),
    Case("truck", "lift the truck up, then drop it", "lift drop sequence"),
    Case("tree", "a storm bends the tree to the right", "bend wind violent"),
    Case("tree", "the crown of the tree sways in a light breeze", "sway wind slight part"),
    Case("tree", "shake the tree", "sway"),
    Case("tree", "a rubber tree is bent far to the left and springs back", "bend material"),
    Case("biker", "someone pushes the biker from the right", "push"),
    Case("biker", "turn the biker around by 180 degrees", "spin quantity"),
    Case("biker", "a very strong wind blows the biker away", "wind violent"),
    Case("chair", "tip the chair over backwards", "tip"),
    Case("chair", "push the backrest of the chair forward", "push part"),
    Case("chair", "squash a chair made of foam", "squeeze material"),
)

_TWENTY = (
    Case("goat", "bend the goat's left horn to the side", "bend part"),
    Case("goat", "turn the goat's head to the left", "spin"),
    Case("goat", "a goat head made of clay falls on the floor", "drop material"),
    Case("goat", "shake the goat head", "sway"),
    Case("barrel", "knock the barrel over", "hit tip"),
    Case("barrel", "crush a steel barrel from above", "squeeze material"),
    Case("barrel", "spin the barrel around", "spin"),
    Case("barrel", "hit the top of the barrel from the right", "hit part"),
    Case("cannon", "push the cannon backwards", "push"),
    Case("cannon", "the muzzle of the cannon is lifted", "lift part"),
    Case("cannon", "the cannon jumps back as it fires", "hit jump"),
    Case("cannon", "twist a cannon made of rubber", "twist material"),
    Case("lumberjack", "a strong wind blows the lumberjack over", "wind tip"),
    Case("lumberjack", "raise the lumberjack's axe", "lift part"),
    Case("lumberjack", "the lumberjack hops on the spot", "jump"),
    Case("lumberjack", "pull the lumberjack's head to the left", "push part"),
    Case("bust", "tilt the bust to the left", "tip"),
    Case("bust", "lift the bust up and set it down gently", "lift sequence slight"),
    Case("bust", "someone taps a bust made of jelly and it wobbles", "hit sway material"),
    Case("bust", "push the top of the bust's crown to the right", "push part"),
)

SETS = {"sixty": _SIXTY, "twenty": _TWENTY}
