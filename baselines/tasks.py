"""Benchmark tasks: a sentence about an object, and an explicit target over the true paths of its particles.

A task is data (`benchmarks/tasks/*.json`): what a method is given is the scene, never the target. The particle judge
(`physagent_jax.metrics`) says whether a clip hits it. Scenes are small, so that one clip takes tenths of a second.
"""

from __future__ import annotations

import dataclasses
import hashlib
import warnings
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

import physagent_jax as pa
from baselines.materials import OWN, Material, choose_material
from baselines.objects import OBJECTS, find_file, is_available
from baselines.task_hashes import hash_task
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error, read_json
from physagent_jax.core.strict import Strict
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.metrics.effort import measure_effort
from physagent_jax.metrics.targets import Target
from physagent_jax.metrics.task_judge import TaskJudgement, judge
from physagent_jax.scene.camera import frame_camera, make_reference_camera
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.config import CameraConfig
from physagent_jax.simulation.simulate import simulate_frames

Family = Literal["drop", "stretch", "sway", "twist", "impulse", "multi", "recovery", "other"]
FAMILIES: tuple[Family, ...] = ("drop", "stretch", "sway", "twist", "impulse", "multi", "recovery")
"""Those of the published tasks; a task of one's own may be of another."""
Split = Literal["development", "test"]

WIDTH, HEIGHT = 320, 240
_SHOWN = 0.9  # [L] to each side of the object that the camera shows, and half of it above and below
_WITNESSES = "witness.json"


class SceneOptions(Strict):
    """The object's surroundings, and the clip's length.

    Attributes:
        world: "ground" (it stands there, gravity acts) or "free" (it floats).
        anchor: What is held.
        frame_count: Frames of the clip, of 0.04 s.
    """

    world: Literal["ground", "free"] = "ground"
    anchor: Literal["none", "base", "top"] = "none"
    frame_count: Annotated[int, Field(ge=8, le=200)] = 26


class TaskSpec(Strict):
    """A task as data.

    Attributes:
        name: Unique; it decides which split the task belongs to.
        sentence: What is asked for, in the viewer's words: left is -x, away from us +y, up +z.
        family: Kind of motion.
        object: Object of `baselines.objects`.
        scene: What surrounds it.
        target: What the sentence means, for the judge; no method sees it.
        task_hash: Hash of all of the task and of its object, so that a changed one is noticed.
        expert: Force field that the scenes of published codes have for this kind of motion; None = none.
        hidden: The force field that made the target of a recovery task; no method sees it.
        begin: Where a method that needs a first force field begins; None = `START`.
        material: Material of the object, for `baselines.materials.choose_material`.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9-]{3,60}$")]
    sentence: Annotated[str, Field(min_length=5, max_length=400)]
    family: Family
    object: str
    scene: SceneOptions = SceneOptions()
    target: Target
    task_hash: str
    expert: ForceField | None = None
    hidden: ForceField | None = None
    begin: ForceField | None = None
    material: str = OWN

    @property
    def split(self) -> Split:
        """By the name alone, so that nobody chooses: test where its SHA-256 is odd.

        What stands before "--" counts: tasks that differ only by a number behind it are twins, and stay together.
        """
        stem = self.name.partition("--")[0]
        return "test" if hashlib.sha256(stem.encode()).digest()[-1] % 2 else "development"

    @property
    def smooth(self) -> bool:
        """Return whether nothing touches or leaves the ground: the object floats in a free world, or it is held.

        There the motion changes smoothly with the force field, and gradients can be expected to serve. All materials of
        tasks are elastic, so that nothing has to break either.
        """
        return self.scene.world == "free" or self.scene.anchor != "none"


START = ForceField(
    actions=(Action(action_type=ActionType.TRANSLATION, vector=(1.0, 0.0, 0.0), magnitude=0.4),)
)
"""The weakest push to the right: says nothing about a task."""


def load_tasks(
    folder: str | Path,
    *,
    split: Split | None = None,
    families: Sequence[str] | None = None,
    changed: bool = False,
) -> tuple[TaskSpec, ...]:
    """Read the tasks of a folder, one file per family, in the order of `FAMILIES` and of the files.

    Args:
        folder: Holds ``<family>.json``.
        split: Only those of this split.
        families: Only these.
        changed: Whether those that are not as they were published are read too, to be recorded again.

    Raises:
        UserError: A file is not a list of tasks, a name appears twice, a task was changed, or a family is unknown.
    """
    if unknown := set(families or ()) - set(FAMILIES):
        raise UserError(f"unknown family `{min(unknown)}`", do=f"Families: {', '.join(FAMILIES)}")
    specs: list[TaskSpec] = []
    for family in FAMILIES:
        path = Path(folder) / f"{family}.json"
        if (families is None or family in families) and path.is_file():
            specs += _read_tasks(path, family, changed)
    if not specs:
        raise UserError(f"there are no tasks in {folder}", do="Give the folder benchmarks/tasks")
    names = [spec.name for spec in specs]
    if twice := {name for name in names if names.count(name) > 1}:
        raise UserError(f"the task `{min(twice)}` is there twice")
    return tuple(spec for spec in specs if split is None or spec.split == split)


def _read_tasks(path: Path, family: str, changed: bool) -> tuple[TaskSpec, ...]:
    adapter = TypeAdapter(tuple[TaskSpec, ...])
    try:
        specs = adapter.validate_python(read_json(path, what="the tasks"))
    except ValidationError as error:
        raise format_validation_error(error, str(path), TaskSpec) from None
    for spec in specs:
        if spec.family != family:
            raise UserError(f"{path}: `{spec.name}` is of the family {spec.family}", do="Move it there")
        check_spec(spec, str(path), changed)
    return specs


def check_spec(spec: TaskSpec, place: str, changed: bool = False) -> None:
    """Refuse a task whose target does not fit it, or, unless it may be ``changed``, that is not as it was published.

    Raises:
        UserError: Its hash differs, it looks beyond the clip, or it is of no known object.
    """
    is_available(spec.object, None)
    if spec.target.last_frame >= spec.scene.frame_count:
        raise UserError(f"{place}: the target of `{spec.name}` looks beyond its clip")
    if (spec.hidden is None) == (spec.family == "recovery"):
        raise UserError(
            f"{place}: `{spec.name}` must have a `hidden` force field if, and only if, it recovers one"
        )
    if not changed and hash_task(spec) != spec.task_hash:
        raise UserError(
            f"{place}: `{spec.name}` or its object was changed: the hash of all that it says is not `task_hash`",
            do="Take the task as it was published, or give another task another name and hash",
        )


def split_available(
    specs: Sequence[TaskSpec], data: Path | None
) -> tuple[tuple[TaskSpec, ...], tuple[str, ...]]:
    """The tasks that can be made with this folder of data, and the names of the others."""
    kept = tuple(spec for spec in specs if is_available(spec.object, data))
    return kept, tuple(spec.name for spec in specs if spec not in kept)


def load_witnesses(folder: str | Path) -> dict[str, ForceField]:
    """For each task a force field with which it is a success: none is impossible. No method sees them.

    Raises:
        UserError: The file is missing or holds no force fields.
    """
    path = Path(folder) / _WITNESSES
    try:
        return TypeAdapter(dict[str, ForceField]).validate_python(read_json(path, what="the witnesses"))
    except ValidationError as error:
        raise format_validation_error(error, str(path), ForceField) from None


@dataclasses.dataclass(frozen=True)
class Task:
    """A task ready to be solved.

    Attributes:
        spec: Its definition.
        loaded: The object, in the domain.
        camera: Camera of all of its clips.
        material: Material of the object.
    """

    spec: TaskSpec
    loaded: pa.LoadedObject
    camera: CameraConfig
    material: Material

    @property
    def target(self) -> Target:
        """For the judge."""
        return self.spec.target

    @property
    def start(self) -> ForceField:
        """The first force field of a method that needs one."""
        return self.spec.begin or START

    @property
    def frame_count(self) -> int:
        """Of the clip."""
        return self.spec.scene.frame_count

    @cached_property
    def frame_dt(self) -> float:
        """[s]."""
        return self.build(self.start).config.timing.frame_dt

    @cached_property
    def mass(self) -> np.ndarray:
        """Of the model's particles [kg], shape (n,); the same for all force fields."""
        return np.asarray(self.build(self.start).model.mass)

    def build(self, force_field: ForceField) -> CompiledScene:
        """The scene in which ``force_field`` acts; object, domain, camera, clip and material are the task's."""
        options = self.spec.scene
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of few particles per cell: small on purpose
            scene = pa.build_scene(
                self.loaded,
                force_field=force_field,
                material=self.material,
                anchor=options.anchor,
                camera=dict(azimuth_degrees=0.0),
                world=options.world,
                frame_count=options.frame_count,
                width=WIDTH,
                height=HEIGHT,
            )
        config = scene.config.model_copy(update=dict(camera=self.camera, prompt=self.spec.sentence))
        camera = make_reference_camera(self.camera, config.rendering, config.domain)
        return dataclasses.replace(scene, config=config, camera=camera)

    def simulate(self, force_field: ForceField) -> np.ndarray:
        """True positions of the model's particles under ``force_field`` [m], shape (frames, n, 3)."""
        frames = simulate_frames(self.build(force_field))
        return np.stack([np.asarray(frame.state.x) for frame in frames])

    def judge(self, x: np.ndarray) -> TaskJudgement:
        """Judge true positions of the model's particles [m], shape (frames, n, 3)."""
        return judge(self.target, x, self.mass, self.frame_dt)

    def measure_effort(self, force_field: ForceField, x: np.ndarray) -> float:
        """Impulse that ``force_field`` hands to each kilogram on the clip ``x``, gravity left out [m/s]."""
        return measure_effort(self.build(force_field).model, x, self.frame_dt)


def make_task(spec: TaskSpec, folder: Path, data: Path | None = None, material: str = OWN) -> Task:
    """Make a task's object.

    Args:
        spec: Which task.
        folder: Where files of objects go that are made.
        data: Folder of captured objects; None = tasks on those cannot be made.
        material: What the object is made of, as for `choose_material`; `OWN` = what the task says. The target stays
            that of the task.

    Raises:
        UserError: The object needs a folder of data that is not given, or there is no such material.
    """
    thing = OBJECTS[spec.object]
    made_of = choose_material(spec.material if material == OWN else material, thing)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        loaded = pa.load_object(
            find_file(spec.object, folder, data),
            up=thing.up,
            kind=thing.kind,
            cells=thing.cells,
            max_particles=thing.particles,
        )
    task = Task(spec, loaded, CameraConfig(), made_of)
    return dataclasses.replace(task, camera=_place_camera(task))


def _place_camera(task: Task) -> CameraConfig:
    """A camera that shows where the object can be expected, whatever acts on it."""
    body, rendering = task.loaded.body, task.build(task.start).config.rendering
    corners = (
        0.5 * (body.low + body.high)
        + 0.5 * (body.high - body.low) * np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    )
    reach = _SHOWN * body.extent * np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 0.5], [0, 0, -0.5]])
    points = np.concatenate([corners + shift for shift in reach])
    return frame_camera(points, CameraConfig(), rendering, start=np.asarray(body.cloud.means, np.float64))
