"""`python -m benchmarks.first_results.objects --into DIR [--from FOLDER]`: fetch the objects that are held back.

They are other people's test assets, so that none is in the repository: each is pinned by its sha256, with the address,
the licence and the credit. A copy that is on the machine is taken by its hash, whatever its name.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import shutil
import sys
import urllib.request
from collections.abc import Iterable, Mapping
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import replace_file

MESHES = "odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects"
COMMON = "alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202/data"
TRIMESH = "mikedh/trimesh/a513c0e2cfa6dfbd3121a6dfd8ceb002b9ef55d8/models"
PLAYCANVAS = "playcanvas/engine/0aaef5e432c4797ed23c1f966e2cc43232ec0613/examples/assets"
BABYLON = "BabylonJS/MeshesLibrary/1e0c5cdbdfec7b632b9aa1f498f7016b0d210779"
_SITE = "https://raw.githubusercontent.com/"
_SECONDS = 60  # that a connection may be silent


@dataclasses.dataclass(frozen=True)
class PinnedFile:
    """A file of somebody else that sentences are tried on.

    Attributes:
        name: Its name, as it was published.
        folder: Repository, commit and folder that it is in.
        sha256: Hash of the whole file.
        credit: Kind of asset, author and licence.
    """

    name: str
    folder: str
    sha256: str
    credit: str

    @property
    def url(self) -> str:
        """The address of the file at its commit."""
        return f"{_SITE}{self.folder}/{self.name}"

    def is_in(self, path: Path) -> bool:
        """Return whether ``path`` is this very file."""
        return path.is_file() and hash_file(path) == self.sha256


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


def hash_file(path: Path) -> str:
    """The sha256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def collect(files: Iterable[PinnedFile], into: Path, folder: Path | None = None) -> list[Path]:
    """Put the files into a folder: those that are there stay, the others are copied or downloaded.

    Args:
        files: The files that are wanted.
        into: The folder that they are put into.
        folder: Folder with copies, looked through with all below it; None = download.

    Raises:
        UserError: A file is not to be had, or is another one than was pinned.
    """
    missing = [file for file in files if not file.is_in(into / file.name)]
    copies = {hash_file(path): path for path in _list_files(folder)} if folder and missing else {}
    for file in missing:
        with replace_file(into / file.name) as temporary:
            if folder is None:
                _download(file, temporary)
            elif file.sha256 in copies:
                shutil.copyfile(copies[file.sha256], temporary)
            else:
                raise UserError(
                    f"{file.name} is not among the copies",
                    got=f"no file in {folder} has the sha256 {file.sha256}",
                    do=f"Fetch {file.url}",
                )
    return [into / file.name for file in files]


def _list_files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _download(file: PinnedFile, path: Path) -> None:
    """Write what the address gives, and refuse another file."""
    try:
        with urllib.request.urlopen(file.url, timeout=_SECONDS) as answer, path.open("wb") as target:
            shutil.copyfileobj(answer, target)
    except OSError as error:
        raise UserError(
            f"{file.name} cannot be downloaded", got=str(error), do="Give a folder of copies with `--from`"
        ) from error
    if (found := hash_file(path)) != file.sha256:
        raise UserError(f"{file.url} gives another file", got=found, do=f"Expected: {file.sha256}")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line."""
    # their kind of file is from here
    from benchmarks.first_results import held_back_again, held_back_fifth, held_back_fourth, held_back_third

    files = dict(FILES)
    for lot in (held_back_again, held_back_third, held_back_fourth, held_back_fifth):
        files |= lot.FILES
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(files)}; none = all")
    parser.add_argument("--into", type=Path, required=True, metavar="DIR", help="the folder of the files")
    parser.add_argument("--from", type=Path, metavar="FOLDER", dest="folder", help="a folder with copies")
    given = parser.parse_args(arguments)
    if unknown := [name for name in given.names if name not in files]:
        print(f"there is no object {unknown[0]}; there are: {', '.join(files)}", file=sys.stderr)
        return 2
    try:
        for path in collect([files[name] for name in given.names or files], given.into, given.folder):
            print(path)
    except UserError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
