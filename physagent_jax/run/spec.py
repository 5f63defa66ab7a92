"""A run as data: everything that says what a run is, in one value that can be written, read and compared."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, JsonValue, ValidationError, field_validator, model_validator

from physagent_jax.agents import registry as agents
from physagent_jax.chat.registry import MODELS
from physagent_jax.core.reading import YAML_SUFFIXES, format_validation_error, read_json, read_yaml
from physagent_jax.core.strict import Seed, Strict
from physagent_jax.forces.part import PartChoice
from physagent_jax.perception import backends
from physagent_jax.run.manifest import MOST_ROUNDS
from physagent_jax.scene.config import MOST_FRAMES, Cutout, SignedAxis, SplatEncoding
from physagent_jax.scene.config.common import Degrees, Friction, HalfSize, Length, Point
from physagent_jax.scene.config.common import Path as FilePath
from physagent_jax.scene.config.photo import Elevation
from physagent_jax.scene.presets import PresetName
from physagent_jax.simulation.notes import Notes


class Implementation(Strict):
    """One of several implementations, by name.

    Attributes:
        name: As in the registry of its role.
        options: What it is made with.
    """

    name: str
    options: dict[str, JsonValue] = {}

    @model_validator(mode="before")
    @classmethod
    def _read_name_alone(cls, value: Any) -> Any:
        return {"name": value} if isinstance(value, str) else value


class PhotoChoice(Cutout):
    """The lifting of a photo.

    Attributes:
        segmenter: Who finds the object in it, of `perception.backends`; None = GrabCut.
        depth: Who estimates how far away each pixel is; None = nobody: the outline is inflated.
        elevation_degrees: Height of its camera above the horizon; None = `camera.elevation_degrees`.
    """

    segmenter: Implementation | None = None
    depth: Implementation | None = None
    elevation_degrees: Elevation | None = None

    @model_validator(mode="after")
    def _check_known(self) -> PhotoChoice:
        for registry, choice in (
            (backends.SEGMENTERS, self.segmenter),
            (backends.DEPTH_ESTIMATORS, self.depth),
        ):
            if choice is not None:
                registry.check(choice.name)
        if self.segmenter is not None and self.mask_path is not None:
            raise ValueError("`mask_path` and `segmenter` both say where the object is: give one of them")
        return self


class ObjectChoice(Strict):
    """The object.

    Attributes:
        path: 3D Gaussians (.ply, .spz, ...), a mesh (.obj, .glb, .stl, .ply) or a photo (.png, .jpg, .webp, .tif),
            absolute or relative to the spec's folder.
        up: The file's own up axis; None = its card's, else the format's (+y for glTF), else +z.
        kind: Class with a physical prior (`scene.priors`); None = its card's, else from the file's name.
        opacity_threshold: Gaussians with a lower opacity are dropped.
        splat_encoding: How the file stores scales and opacities (`gaussians.formats.encoding`); None = found from
            its content.
        extent: Longest side in the domain [m].
        parts: Parts that a person names, for sentences to speak of.
        photo: How a photo is cut out and lifted; None = as what stands out in it (photos only).
    """

    path: FilePath
    up: SignedAxis | None = None
    kind: str | None = None
    opacity_threshold: float = Field(default=0.02, ge=0, lt=1)
    splat_encoding: SplatEncoding | None = None
    extent: Length = 1.0
    parts: Annotated[tuple[PartChoice, ...], Field(max_length=64)] = ()
    photo: PhotoChoice | None = None


class Overrides(Strict):
    """Differences from the preset; None = nothing. Ranges are those of the scene's schema.

    Attributes:
        cells: Cells along a side of the domain.
        frame_count: Frames of the clip.
        max_particles: Particles at most.
        width, height: Width and height of the pictures [px].
    """

    cells: int | None = None
    frame_count: int | None = None
    max_particles: int | None = None
    width: int | None = None
    height: int | None = None


class MaterialChoice(Strict):
    """The choice of a material.

    Attributes:
        name: A named material, or a constitutive model with the kind's values; None = the kind's prior.
        physgm: ``predicted_phys.json`` of PhysGM, in place of a name.
        soften: Factor by which it is made softer, with the same strains at yield; "auto" = so that a round is
            affordable.
        youngs_modulus: E [Pa]; None = the material's.
        poissons_ratio: nu; None = the material's.
        density: [kg/m^3]; None = the material's.
        damping_ratio: Share of critical damping of the object's lowest mode, in [0, 1]; None = the material's, else as
            much of its kind's as costs few substeps (`scene.damping`).
    """

    name: str | None = None
    physgm: FilePath | None = None
    soften: float | Literal["auto"] | None = None
    youngs_modulus: float | None = None
    poissons_ratio: float | None = None
    density: float | None = None
    damping_ratio: float | None = None

    @model_validator(mode="after")
    def _check_one_of(self) -> MaterialChoice:
        if self.name is not None and self.physgm is not None:
            raise ValueError("`physgm` and `name` both say what the object is made of: give one of them")
        return self

    @property
    def says_stiffness(self) -> bool:
        """Return whether somebody has chosen how stiff it is."""
        return any(each is not None for each in (self.name, self.physgm, self.soften, self.youngs_modulus))


class AnchorChoice(Strict):
    """The choice of particles that are held.

    Attributes:
        kind: "auto" = what the sentence says, else what the object's kind implies unless a motion needs it free.
        point, half_size: Centre and half size of a "box" [m]; the object's longest side is 1 m, centred in the domain.
        mask_path: ``.npy`` of one bool per Gaussian, for a "mask".
    """

    kind: Literal["auto", "none", "base", "top", "box", "mask"] = "auto"
    point: Point | None = None
    half_size: HalfSize | None = None
    mask_path: FilePath | None = None

    @model_validator(mode="after")
    def _check_complete(self) -> AnchorChoice:
        given = {"box": (self.point, self.half_size), "mask": (self.mask_path,)}
        for kind, values in given.items():
            if self.kind == kind and None in values:
                raise ValueError(f'anchor kind "{kind}" needs a {kind}')
            if self.kind != kind and any(value is not None for value in values):
                raise ValueError(f'a {kind} means nothing without anchor kind "{kind}"')
        return self


class CameraChoice(Strict):
    """The choice of a camera; its distance follows from what is to be seen.

    Attributes:
        azimuth_degrees: About the vertical; None = the card's, else where the object's broad side is seen.
        elevation_degrees: Above the horizon; None = the photo's, else 10.
        follow: Whether it goes along with the object in the video for people; None = only if that would else be too
            small in it.
    """

    azimuth_degrees: Degrees | None = None
    elevation_degrees: Elevation | None = None
    follow: bool | None = None


class AgentChoice(Strict):
    """The choice of agents: one reads the sentence, one judges the motion, one rewrites the force field.

    Attributes:
        semantic: "grammar", "model", or "both" = the grammar's reading, which the model may doubt.
        planner: "rules", "chat" = a model, or "both" = in agreement.
        executor: "rules" or "chat".
        model: The chat model that those ask which ask one. A key is never part of it: it comes from the environment.
    """

    semantic: Implementation = Implementation(name="grammar")
    planner: Implementation = Implementation(name="rules")
    executor: Implementation = Implementation(name="rules")
    model: Implementation | None = None

    @model_validator(mode="after")
    def _check_known(self) -> AgentChoice:
        chosen = (
            (agents.SEMANTIC, self.semantic),
            (agents.PLANNER, self.planner),
            (agents.EXECUTOR, self.executor),
        )
        for registry, choice in chosen:
            registry.check(choice.name)
        asking = [
            f"{registry.what} {choice.name!r}"
            for registry, choice in chosen
            if choice.name in agents.ASK_A_MODEL
        ]
        if self.model is not None:
            MODELS.check(self.model.name)
            if not asking:
                raise ValueError(
                    "`agents.model` names a language model that no agent asks: choose one that does"
                )
        elif asking:
            raise ValueError(
                f"{asking[0]} asks a language model, and `agents.model` names none: name one, like "
                '{"name": "openai", "options": {"url": "http://127.0.0.1:8000/v1", "model": "NAME"}}'
            )
        return self

    def located(self, base_dir: str | Path) -> AgentChoice:
        """The choice with an absolute path of the model's file, if it is a file."""
        path = self.model and self.model.options.get("path")
        if self.model is None or not isinstance(path, str):
            return self
        options = {**self.model.options, "path": str((Path(base_dir) / path).resolve())}
        return self.model_copy(update=dict(model=self.model.model_copy(update=dict(options=options))))


Share = Annotated[float, Field(ge=0, le=1)]  # of the picture's width or height, from its upper left corner
MOST_POINTS = 256


class PromptChoice(Strict):
    """A prompt that marks the object in one frame: points, a box, both, or a mask alone.

    Shares of the picture rather than pixels, so that it holds at any resolution, that of coarse rounds too.

    Attributes:
        frame: The frame that it speaks of.
        points: Positions (x, y) [share of width, height].
        labels: True where a point is on the object, False where it is on something else; None = all on it.
        box: Corners (x0, y0, x1, y1) [share of width, height].
        mask_path: ``.npy`` of one bool per pixel, shape (height, width).
    """

    frame: int = Field(default=0, ge=0, lt=MOST_FRAMES)
    points: Annotated[tuple[tuple[Share, Share], ...], Field(min_length=1, max_length=MOST_POINTS)] | None = (
        None
    )
    labels: Annotated[tuple[bool, ...], Field(max_length=MOST_POINTS)] | None = None
    box: tuple[Share, Share, Share, Share] | None = None
    mask_path: FilePath | None = None

    @model_validator(mode="after")
    def _check_one_thing(self) -> PromptChoice:
        outlined = self.points is not None or self.box is not None
        if outlined == (self.mask_path is not None):
            raise ValueError("a prompt is points, a box, both, or a mask alone: give one of these")
        if self.labels is not None and len(self.labels) != len(self.points or ()):
            raise ValueError("`labels` are one per point: give as many, or none")
        if self.box is not None and not (self.box[0] < self.box[2] and self.box[1] < self.box[3]):
            raise ValueError(f"`box` is x0 y0 x1 y1 with x0 < x1 and y0 < y1 (got {self.box})")
        return self


class PerceptionChoice(Strict):
    """The choice of backends: segmenter, depth estimator, tracker.

    Also given as text: "rgbd", with a depth channel; "rgb", from pictures alone; or what differs from one of them, as
    in "rgb,tracker=NAME".

    Attributes:
        segmenter, depth, tracker: By name.
        prompt: Which object is meant; None = the one that stands out, if the segmenter has to be told.
    """

    segmenter: Implementation = Implementation(name="rgbd")
    depth: Implementation = Implementation(name="sensor")
    tracker: Implementation = Implementation(name="flow")
    prompt: PromptChoice | None = None

    @model_validator(mode="before")
    @classmethod
    def _read_text(cls, value: Any) -> Any:
        return backends.parse_choice(value) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _check_known(self) -> PerceptionChoice:
        for registry, choice in (
            (backends.SEGMENTERS, self.segmenter),
            (backends.DEPTH_ESTIMATORS, self.depth),
            (backends.TRACKERS, self.tracker),
        ):
            registry.check(choice.name)
        return self

    def located(self, base_dir: str | Path) -> PerceptionChoice:
        """The choice with absolute paths of the models' files, where such files are below ``base_dir``."""
        changes: dict[str, Any] = {}
        for role in _ROLES:
            chosen: Implementation = getattr(self, role)
            options = {
                name: _locate(value, Path(base_dir)) if name in _PLACES else value
                for name, value in chosen.options.items()
            }
            changes[role] = chosen.model_copy(update=dict(options=options))
        return self.model_copy(update=changes)


_ROLES = ("segmenter", "depth", "tracker")
_PLACES = ("weights", "path", "python")
"""Options of perception's models that say where their files are; their names tell which (`Backend.name`)."""


def _locate(value: JsonValue, base_dir: Path) -> JsonValue:
    """A path that is there as an absolute one; names of a hub or of programs as they are."""
    if not isinstance(value, str):
        return value
    path = base_dir / Path(value).expanduser()
    return str(path.resolve()) if path.exists() else value


VIDEO_SIZE = (1280, 720)
VideoSize = tuple[Annotated[int, Field(ge=16, le=4096)], Annotated[int, Field(ge=16, le=4096)]]


class SaveChoice(Strict):
    """The choice of files beside motion and report.

    Attributes:
        video_size: Width and height of the video for people [px]; None = there is none, only perception's pictures.
        frames: Perception's pictures as PNG.
        caption: Whether the sentence is written into the video.
        arrows: Whether arrows in it show what acts.
        splats: Format of one file of 3D Gaussians per frame; False = none is left. True = "ply".
    """

    video_size: VideoSize | None = VIDEO_SIZE
    caption: bool = False
    arrows: bool = False
    frames: bool = False
    splats: Literal["ply", "spz", "glb", False] = False

    @property
    def notes(self) -> Notes:
        """The choice of what is drawn over the video."""
        return Notes(self.caption, self.arrows)

    @field_validator("splats", mode="before")
    @classmethod
    def _name_format(cls, value: object) -> object:
        return "ply" if value is True else value


class RunSpec(Strict):
    """Everything that says what a run is.

    Attributes:
        object: The object.
        prompt: What should happen, in everyday English.
        preset: Named set of defaults.
        overrides: What differs from it.
        material: What the object is made of.
        anchor: What is held.
        camera: Where the camera stands.
        world: "ground": gravity acts and the object stands on the ground, unless the sentence says otherwise;
            "free": it floats in empty space, as in the paper; gravity and ground are there only for what falls.
        friction: Friction of the ground; None = `calibration.FRICTION`, and none in the free world.
        agents, perception: Who does what, by name.
        rounds: At most.
        probe: Whether force fields are first tried on a coarse version of the scene.
        seed: Seed of all random numbers.
        ledger: Whether exchanged energy and momentum are recorded, frame by frame.
        save: What else is left.
    """

    object: ObjectChoice
    prompt: str
    preset: PresetName = PresetName.FAST
    overrides: Overrides = Overrides()
    material: MaterialChoice = MaterialChoice()
    anchor: AnchorChoice = AnchorChoice()
    camera: CameraChoice = CameraChoice()
    world: Literal["ground", "free"] = "ground"
    friction: Friction | None = None
    agents: AgentChoice = AgentChoice()
    perception: PerceptionChoice = PerceptionChoice()
    rounds: int = Field(default=3, ge=1, le=MOST_ROUNDS)
    probe: bool = False
    seed: Seed = 0
    ledger: bool = False
    save: SaveChoice = SaveChoice()

    def files(self, base_dir: str | Path = ".") -> dict[str, Path]:
        """The files that the run reads, by what they are."""
        named = {
            "object": self.object.path,
            "image_mask": self.object.photo and self.object.photo.mask_path,
            "physgm": self.material.physgm,
            "anchor_mask": self.anchor.mask_path,
            "prompt_mask": self.perception.prompt and self.perception.prompt.mask_path,
        }
        return {what: Path(base_dir) / path for what, path in named.items() if path is not None}

    def located(self, base_dir: str | Path) -> RunSpec:
        """The spec with absolute paths, so that it can be read from anywhere."""
        paths = {what: str(path.resolve()) for what, path in self.files(base_dir).items()}
        prompt, photo = self.perception.prompt, self.object.photo
        if photo is not None:
            photo = photo.model_copy(update=dict(mask_path=paths.get("image_mask")))
        if prompt is not None:
            prompt = prompt.model_copy(update=dict(mask_path=paths.get("prompt_mask")))
        return self.model_copy(
            update=dict(
                object=self.object.model_copy(update=dict(path=paths["object"], photo=photo)),
                material=self.material.model_copy(update=dict(physgm=paths.get("physgm"))),
                anchor=self.anchor.model_copy(update=dict(mask_path=paths.get("anchor_mask"))),
                agents=self.agents.located(base_dir),
                perception=self.perception.located(base_dir).model_copy(update=dict(prompt=prompt)),
            )
        )

    def identity(self) -> dict[str, Any]:
        """The values that tell this run from others.

        The places of its files on the disk are not part of it, nor are the places of its models: they are in the names
        of agents and backends (`Agents.names`, `PerceptionBackends.names`), which a run folder keeps beside this.
        """
        paths: dict[str, Any] = {
            "agents": {"model"},
            "object": {"path": True, "photo": {"mask_path"}},
            "material": {"physgm"},
            "anchor": {"mask_path"},
            "perception": {"prompt": {"mask_path"}} | {role: {"options": set(_PLACES)} for role in _ROLES},
        }
        return self.model_dump(mode="json", exclude=paths)


def read_spec(path: str | Path) -> RunSpec:
    """Read a spec from JSON, or from YAML if the file's suffix says so.

    Raises:
        UserError: The file is no such spec.
    """
    path, what = Path(path), "the run's spec"
    data = read_yaml(path, what=what) if path.suffix.lower() in YAML_SUFFIXES else read_json(path, what=what)
    try:
        return RunSpec.model_validate(data)
    except ValidationError as error:
        raise format_validation_error(
            error, str(path), RunSpec, do="`physagent schema run` prints the schema"
        ) from None
