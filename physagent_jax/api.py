"""The verbs of the front door: `physagent_jax` hands them on, each imported when it is first asked for."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from physagent_jax.agents.protocols import Agents
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error
from physagent_jax.forces.schema import ForceField
from physagent_jax.perception.protocols import PerceptionBackends
from physagent_jax.run.chosen_agents import open_agents
from physagent_jax.run.finished import FinishedRun, open_run
from physagent_jax.run.loop import run_loop
from physagent_jax.run.observer import Observer
from physagent_jax.run.reading import place_for_field, read_for_scene
from physagent_jax.run.resolve import ResolvedRun, resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene.body import Body, make_body, make_scene_body
from physagent_jax.scene.compile import CompiledScene, compile_scene
from physagent_jax.scene.config import Source, SplatEncoding
from physagent_jax.scene.cost import Limits
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.scene_file import read_scene


@dataclasses.dataclass(frozen=True)
class LoadedObject:
    """An object at rest in the domain, as particles and Gaussians.

    Attributes:
        spec: How it was loaded.
        source: How it was placed.
        body: Gaussians, particles, and how they hang together.
    """

    spec: RunSpec
    source: Source
    body: Body


def load_object(
    path: str | Path,
    *,
    up: str | None = None,
    kind: str | None = None,
    opacity_threshold: float = 0.02,
    splat_encoding: str | None = None,
    extent: float = 1.0,
    parts: Sequence[Mapping[str, Any]] = (),
    photo: Mapping[str, Any] | None = None,
    preset: str = "fast",
    cells: int | None = None,
    max_particles: int | None = None,
    seed: int = 0,
) -> LoadedObject:
    """Read an object's file, place it in the domain and fill it with particles.

    Args:
        path: 3D Gaussians (.ply, .spz, ...), a mesh (.obj, .glb, .stl, .ply) or a photo (.png, .jpg, ...).
        up: The file's own up axis ("-y"); None = its card's, else the format's ("+y" for glTF), else "+z".
        kind: Class with a physical prior ("plant", "food", ...); None = its card's, else from the file's name.
        opacity_threshold: Gaussians with a lower opacity are dropped.
        splat_encoding: How the file stores scales and opacities ("log-logit", "plain-plain", "log-plain",
            "plain-logit"); None = found from its content.
        extent: Its longest side in the domain [m].
        parts: Parts that are named for the sentence, each with the fields of `forces.part.PartChoice`.
        photo: How the object of a photo is cut out and lifted: fields of `run.spec.PhotoChoice`; None = as what
            stands out in it.
        preset: "fast" or "paper": domain, grid, particles, frames.
        cells: Cells along a side of the domain; None = the preset's.
        max_particles: Particles at most; None = the preset's.
        seed: Seed of all random numbers.

    Raises:
        UserError: The file cannot be used, or a value is out of range.
    """
    spec = _validate(
        object=dict(
            path=str(path),
            up=up,
            kind=kind,
            opacity_threshold=opacity_threshold,
            splat_encoding=splat_encoding,
            extent=extent,
            parts=tuple(parts),
            photo=photo if photo is None else dict(photo),
        ),
        prompt="",
        preset=preset,
        overrides=dict(cells=cells, max_particles=max_particles),
        seed=seed,
    )
    template = resolve(spec).template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    return LoadedObject(spec.located("."), template.source, body)


def build_scene(
    loaded: LoadedObject,
    prompt: str = "",
    *,
    force_field: ForceField | Mapping[str, Any] | None = None,
    material: str | Mapping[str, Any] | None = None,
    anchor: str | Mapping[str, Any] = "auto",
    camera: Mapping[str, Any] | None = None,
    world: str = "ground",
    friction: float | None = None,
    frame_count: int | None = None,
    width: int | None = None,
    height: int | None = None,
    ledger: bool = False,
    agents: Mapping[str, Any] | None = None,
) -> CompiledScene:
    """A scene of an object and what acts on it, ready to be simulated.

    Args:
        loaded: The object.
        prompt: What should happen, for the semantic agent to read.
        force_field: What acts, in place of a sentence; None and no sentence = nothing.
        material: A name, or fields of `run.spec.MaterialChoice`; None = what the object's kind implies.
        anchor: A kind, or fields of `run.spec.AnchorChoice`; "auto" = what the sentence says, else what the kind
            implies.
        camera: Fields of `run.spec.CameraChoice`.
        world: "ground" (it stands there, gravity acts) or "free" (it floats), unless the sentence says otherwise.
        friction: Friction of the ground; None = that of a dry floor, and none in the free world.
        frame_count: Frames of the clip; None = what the sentence asks for, else the preset's.
        width: Width of the pictures [px]; None = the preset's.
        height: Height of the pictures [px]; None = the preset's.
        ledger: Whether exchanged energy and momentum are recorded.
        agents: Fields of `run.spec.AgentChoice`; None = the grammar reads.

    Raises:
        UserError: The sentence is not understood, a value is out of range, both a sentence and a force field are
            given, or the sentence asks for what a held object cannot do.
    """
    if prompt and force_field is not None:
        raise UserError("`prompt` and `force_field` both say what acts", do="Give one of them")
    changed = loaded.spec.model_dump(mode="json")
    changed["overrides"] |= dict(frame_count=frame_count, width=width, height=height)
    changed |= dict(
        prompt=prompt,
        material=dict(name=material) if isinstance(material, str) else dict(material or {}),
        anchor=dict(kind=anchor) if isinstance(anchor, str) else dict(anchor),
        camera=dict(camera or {}),
        world=world,
        friction=friction,
        ledger=ledger,
        agents=dict(agents or {}),
    )
    run = resolve(_validate(**changed), source=loaded.source)
    for text in run.warnings:
        warnings.warn(text, UserWarning, stacklevel=2)
    if prompt:
        with open_agents(run.spec, run.base_dir) as chosen:
            reply = read_for_scene(run, loaded.body, chosen.semantic.compile).value
        field, (template, notes) = reply.force_field, run.place(loaded.body, reply)
    else:
        field = _make_force_field(force_field)
        template, notes = place_for_field(run, loaded.body, field)
    for text in notes:
        warnings.warn(text, UserWarning, stacklevel=2)
    return compile_scene(fuse(template, loaded.body, field), loaded.body, run.base_dir)


def load_scene(
    path: str | Path,
    *,
    object_path: str | Path | None = None,
    splat_encoding: SplatEncoding | None = None,
) -> CompiledScene:
    """A scene file, ready to be simulated: ``scene.json`` of a run, or a PhysGaussian config.

    Args:
        path: The file; relative paths in it start from its folder.
        object_path: The object's file, where the scene does not name it (PhysGaussian) or it has moved.
        splat_encoding: How the object's scales and opacities are stored; None = as the scene says, else found out.

    Raises:
        UserError: The file is not a scene, or the object that it needs is not given or cannot be used.
    """
    path = Path(path)
    config, notes = read_scene(path, None if object_path is None else Path(object_path), splat_encoding)
    for text in notes:
        warnings.warn(text, UserWarning, stacklevel=2)
    return compile_scene(config, make_scene_body(config, path.parent), path.parent)


def synthesize(
    spec: RunSpec | ResolvedRun | str | Path,
    out: str | Path,
    *,
    agents: Agents | None = None,
    backends: PerceptionBackends | None = None,
    observer: Observer | None = None,
    limits: Limits | None = None,
    overwrite: bool = False,
) -> FinishedRun:
    """Run the closed loop into a folder and write its report; a stopped run goes on.

    Args:
        spec: The run, or a file that holds it.
        out: Run folder.
        agents: Who reads, judges and rewrites; None = whom the spec names.
        backends: What perception sees with; None = what the spec names.
        observer: Told of the progress.
        limits: What a round may take.
        overwrite: Replace another run in ``out``.

    Raises:
        UserError: Input that a person can mend.
    """
    from physagent_jax.report.html import write_report

    if isinstance(spec, str | Path):
        from physagent_jax.run.spec import read_spec

        spec = resolve(read_spec(spec), Path(spec).parent)
    run = resolve(spec) if isinstance(spec, RunSpec) else spec
    store = run_loop(
        run, out, agents=agents, backends=backends, observer=observer, limits=limits, overwrite=overwrite
    )
    write_report(store.path)
    return open_run(store.path)


def _validate(**fields: Any) -> RunSpec:
    try:
        return RunSpec.model_validate(fields)
    except ValidationError as error:
        do = "`physagent schema run` prints the schema"
        raise format_validation_error(error, "arguments", RunSpec, do=do) from None


def _make_force_field(value: ForceField | Mapping[str, Any] | None) -> ForceField:
    if isinstance(value, BaseModel | None):
        return value if isinstance(value, ForceField) else ForceField()
    try:
        return ForceField.model_validate(dict(value))
    except ValidationError as error:
        raise format_validation_error(error, "`force_field`", ForceField) from None
