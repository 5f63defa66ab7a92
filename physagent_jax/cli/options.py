"""The options of `physagent run` as a `RunSpec`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from physagent_jax.cli.parts import parse_part
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error

if TYPE_CHECKING:
    from physagent_jax.agents.schema import SemanticReply
    from physagent_jax.run.spec import RunSpec

OPTIONS = {
    "object.path": "--object",
    "object.up": "--up",
    "object.kind": "--kind",
    "object.opacity_threshold": "--opacity-threshold",
    "object.splat_encoding": "--splat-encoding",
    "object.parts": "--part",
    "object.photo.box": "--image-box",
    "object.photo.mask_path": "--image-mask",
    "object.photo.segmenter": "--image-segmenter",
    "object.photo.depth": "--image-depth",
    "object.photo.fov_degrees": "--image-fov",
    "prompt": "--prompt",
    "preset": "--preset",
    "overrides.frame_count": "--frames",
    "overrides.max_particles": "--particles",
    "overrides.width": "--resolution",
    "material.name": "--material",
    "material.physgm": "--physgm",
    "material.soften": "--soften",
    "material.youngs_modulus": "--youngs-modulus",
    "material.poissons_ratio": "--poissons-ratio",
    "material.density": "--density",
    "material.damping_ratio": "--damping-ratio",
    "anchor.kind": "--anchor",
    "anchor.mask_path": "--anchor-mask",
    "camera.azimuth_degrees": "--azimuth",
    "camera.elevation_degrees": "--elevation",
    "world": "--world",
    "friction": "--friction",
    "agents.semantic.name": "--reader",
    "agents.semantic.options.form": "--form",
    "agents.planner.name": "--planner",
    "agents.executor.name": "--executor",
    "perception.segmenter": "--segmenter",
    "perception.depth": "--depth",
    "perception.tracker": "--tracker",
    "perception": "--perception",
    "rounds": "--max-iterations",
    "probe": "--probe",
    "seed": "--seed",
    "ledger": "--ledger",
    "camera.follow": "--follow",
    "save.video_size": "--video-size",
    "save.caption": "--caption",
    "save.arrows": "--arrows",
    "save.frames": "--save-frames",
    "save.splats": "--save-splats",
}
"""The option that sets each field of the spec; the box of an anchor and the pictures' height have theirs below."""

_BESIDE = {
    "out",
    "spec",
    "record",
    "max_minutes",
    "max_memory",
    "overwrite",
    "json_line",
}  # not what a run is


def to_spec(options: Mapping[str, Any]) -> RunSpec:
    """Convert ``options`` to the names of `Run`'s fields.

    Raises:
        UserError: An option is missing, out of range, excluded by another or meaningless without it.
    """
    from physagent_jax.perception import backends
    from physagent_jax.run.models import parse_choice
    from physagent_jax.run.spec import RunSpec

    if options["image"] is not None:
        if options["object"] is not None:
            raise UserError("`--object` and `--image` both say what moves", do="Pass one of them")
        options = {**options, "object": options["image"]}
    missing = [f"--{name}" for name in ("object", "prompt") if options[name] is None]
    if missing:
        raise UserError(f"{' and '.join(missing)} must be given", do="Give them, or --spec file.json")
    _check_pairs(options)
    values = {field: _simplify(options[_name_attribute(option)]) for field, option in OPTIONS.items()}
    values["object.parts"] = list(map(parse_part, options["part"]))
    for role, name in backends.parse_choice(values.pop("perception")).items():
        values[f"perception.{role}"] = parse_choice(role, options[role] or name)
    values["overrides.height"] = values["overrides.width"]
    values["camera.follow"] = options["follow"] or None
    _check_model(options)
    model = choose_model(options["llm"], options["model"], options["replay"], eyes=options["eyes"])
    video_size = parse_size(values.pop("save.video_size"))
    if (box := options["anchor_box"]) is not None:
        values["anchor.point"], values["anchor.half_size"] = box[:3], box[3:]
    try:
        tree = _nest(values)
        if options["image"] is not None:
            tree["object"].setdefault("photo", {})
        tree["agents"]["model"] = model
        tree["save"]["video_size"] = video_size  # None too says something here
        return RunSpec.model_validate(tree)
    except ValidationError as error:
        raise format_validation_error(
            error, "command line", do="`physagent run --help` lists the options"
        ) from None


def choose_prompt(prompt: str | None, sentence: str | None) -> str | None:
    """The sentence of ``--prompt``, or the one that stands without an option.

    Raises:
        UserError: There are both, and they differ.
    """
    if prompt is not None and sentence is not None and prompt != sentence:
        raise UserError(
            "two sentences are given", got=f"{prompt!r} and {sentence!r}", do="Pass one, by --prompt"
        )
    return sentence if prompt is None else prompt


def parse_size(text: str) -> tuple[int, int] | None:
    """Width and height of ``--video-size`` [px]; None for "off".

    Raises:
        UserError: The text is neither a size nor "off", or the size is out of range.
    """
    if text == "off":
        return None
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isascii() and part.isdecimal() and len(part) <= 4 for part in parts):
        raise UserError("`--video-size` is a width and a height, or off", got=text, do="Pass 1280x720")
    width, height = map(int, parts)
    if not 16 <= min(width, height) <= max(width, height) <= 4096:
        raise UserError("`--video-size` must be 16 to 4096 pixels a side", got=text, do="Pass 1280x720")
    return width, height


def choose_model(
    place: str | None, name: str | None, cassette: Path | None, *, eyes: bool = False
) -> dict[str, Any] | None:
    """The language model of ``--llm``, ``--model``, ``--eyes`` and ``--replay``; None if they name none.

    Raises:
        UserError: They exclude each other, or one means nothing without another.
    """
    if cassette is not None:
        if place is not None or name is not None:
            raise UserError(
                "`--replay` and `--llm` both say who answers",
                do="Pass one of them; the cassette knows its model",
            )
        return {"name": "replay", "options": {"path": str(cassette)}}
    if place is None:
        for option, given in (("--model", name is not None), ("--eyes", eyes)):
            if given:
                raise UserError(
                    f"`{option}` means nothing without `--llm`", do="Pass --llm http://HOST:PORT/v1"
                )
        return None
    seeing = {"eyes": True} if eyes else {}
    if place.startswith(("http://", "https://")):
        if name is None:
            raise UserError(
                "`--llm` needs the model's name", got=place, do="Pass --model NAME, as the server has it"
            )
        return {"name": "openai", "options": {"url": place, "model": name, **seeing}}
    path = Path(place)
    if name is not None:
        raise UserError("`--model` means nothing with a model's file", got=place, do="Leave it out")
    if path.is_dir():
        return {"name": "transformers", "options": {"path": place, **seeing}}
    if path.is_file():
        return {"name": "llama", "options": {"path": place, **seeing}}
    raise UserError(
        "`--llm` is a server's address, a GGUF file or a folder with a model",
        got=place,
        do="Pass http://HOST:PORT/v1, or a path that exists",
    )


def read_whole_spec(path: Path, changed: Iterable[str]) -> RunSpec:
    """The spec in the file of ``--spec``.

    Args:
        path: The file.
        changed: Names of the fields of `Run` that are not at their defaults.

    Raises:
        UserError: The file is no spec, or an option says what the file says.
    """
    from physagent_jax.run.spec import read_spec

    given = [_name_option(name) for name in changed if name not in _BESIDE]
    if given:
        raise UserError(
            "`--spec` says all of the run, and so do other options",
            got=", ".join(given),
            do="Leave them out, or write them into the file",
        )
    return read_spec(path)


@contextmanager
def report_as_options() -> Iterator[None]:
    """Errors within name fields of the spec by the options that set them."""
    try:
        yield
    except UserError as error:
        raise UserError(name_options(error.what), got=error.got, do=name_options(error.do)) from None


def name_options(text: str) -> str:
    """``text`` with the options' names for the spec's fields."""
    for field, option in OPTIONS.items():
        text = text.replace(f"field `{field}`", f"`{option}`")
        if "." in field:  # a single word may mean something else
            text = text.replace(f"`{field}`", f"`{option}`")
    return text


def describe_unknown(reply: SemanticReply) -> str:
    """The words that led to nothing, and how the object is called, which one of them may be meant for."""
    doubted = any(f"'{word}'" in doubt for word in reply.not_understood for doubt in reply.unsure)
    hint = " (the object is called by its file's name, its kind, or its card's `name`)" if doubted else ""
    return ", ".join(reply.not_understood) + hint


def _check_pairs(options: Mapping[str, Any]) -> None:
    """Refuse options that exclude each other, or that mean nothing without another."""
    beside = [name for name in _OF_AN_IMAGE if options[name] is not None and options["image"] is None]
    if beside:
        option = _name_option(beside[0])
        raise UserError(f"`{option}` means nothing without `--image`", do="Pass --image, or leave it out")
    if options["physgm"] is not None and options["material"] is not None:
        raise UserError(
            "`--physgm` and `--material` both say what the object is made of", do="Pass one of them"
        )
    for kind in ("box", "mask"):
        option, given = f"--anchor-{kind}", options[f"anchor_{kind}"] is not None
        if given and options["anchor"] != kind:
            raise UserError(
                f"`{option}` means nothing without `--anchor {kind}`",
                got=f"--anchor {options['anchor']}",
                do=f"Pass `--anchor {kind}`, or leave `{option}` out",
            )
        if options["anchor"] == kind and not given:
            example = "x y z hx hy hz" if kind == "box" else "mask.npy"
            raise UserError(f"`--anchor {kind}` needs a {kind}", do=f"Pass {option} {example}")


_OF_AN_IMAGE = ("image_box", "image_mask", "image_segmenter", "image_depth", "image_fov")
_ASKING = {"reader": ("model", "both"), "planner": ("chat", "both"), "executor": ("chat",)}


def _check_model(options: Mapping[str, Any]) -> None:
    """Refuse an agent that asks a model where none is named, and a model that nobody asks."""
    asking = [f"--{role} {options[role]}" for role, names in _ASKING.items() if options[role] in names]
    named = options["llm"] is not None or options["replay"] is not None
    if asking and not named:
        raise UserError(
            f"`{asking[0]}` asks a language model, and none is named",
            do="Pass --llm http://HOST:PORT/v1 --model NAME, --llm with a model's file or folder, or --replay CASSETTE",
        )
    if named and not asking:
        raise UserError(
            f"`--{'llm' if options['llm'] is not None else 'replay'}` names a language model that nobody asks",
            do="Pass --reader model, --planner chat or --executor chat too",
        )
    if options["form"] is not None and options["reader"] == "grammar":
        raise UserError(
            "`--form` means nothing where no model reads", do="Pass --reader model, or leave it out"
        )
    if options["record"] is not None and options["llm"] is None:
        raise UserError("`--record` has nothing to record without `--llm`", do="Pass --llm, or leave it out")


def _nest(values: dict[str, Any]) -> dict[str, Any]:
    """Values by dotted names as a tree; what is None is left out, for the spec's own default."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *branches, leaf = name.split(".")
        if value is None:
            continue
        branch = tree
        for each in branches:
            branch = branch.setdefault(each, {})
        branch[leaf] = value
    return tree


def _simplify(value: Any) -> Any:
    """A path as text, all else as it is."""
    return str(value) if hasattr(value, "__fspath__") else value


def _name_attribute(option: str) -> str:
    return option.removeprefix("--").replace("-", "_")


def _name_option(attribute: str) -> str:
    return "--" + attribute.replace("_", "-")
