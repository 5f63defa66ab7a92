"""The inspection of an object file: its contents, its up axis, and the run that it would make."""

from __future__ import annotations

import shlex
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error, shorten
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians.diagnosis import diagnose_cloud
from physagent_jax.gaussians.formats import LoadedSplats, find_format, read_head
from physagent_jax.run.brief import make_brief
from physagent_jax.run.findings import FoundPart, Inspection, Kind, Piece, PlannedRun
from physagent_jax.run.part_marks import find_masks, find_owners
from physagent_jax.run.preview import check_preview, draw_preview, write_preview
from physagent_jax.run.resolve import ResolvedRun, resolve
from physagent_jax.run.spec import ObjectChoice, RunSpec
from physagent_jax.run.up_axis import UPRIGHT, choose_up, load_as_it_lies
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.card import ObjectCard, load_card
from physagent_jax.scene.config import SignedAxis
from physagent_jax.scene.cost import Limits, check_cost, estimate_cost
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.load import is_photo
from physagent_jax.scene.mesh_files import read_mesh
from physagent_jax.scene.pieces import explain_loose
from physagent_jax.scene.placement import place
from physagent_jax.scene.priors import PRIORS, UNKNOWN, find_kind, guess_kind

SENTENCE = "push it to the left"
"""The sentence of the command line that is suggested."""


def inspect_object(
    path: str | Path,
    *,
    up: SignedAxis | None = None,
    kind: str | None = None,
    splat_encoding: str | None = None,
    opacity_threshold: float = 0.02,
    parts: Sequence[Mapping[str, Any]] = (),
    preview: str | Path | None = None,
    overwrite: bool = False,
) -> Inspection:
    """Read an object file and say what it is, which way up it is, and what a run of it would take.

    Args:
        path: 3D Gaussians or a mesh, as of `load_object`.
        up: The file's up axis; None = its card's, its format's, else guessed from the shape.
        kind: Class of the object; None = its card's, else from the file's name.
        splat_encoding: Reading of scales and opacities; None = found from the content.
        opacity_threshold: Gaussians with a lower opacity are dropped.
        parts: Parts that are named, each with the fields of `forces.part.PartChoice`.
        preview: PNG to write with the object from four sides, its parts coloured and numbered; None = none is written.
        overwrite: Replace a file at ``preview`` that is no preview.

    Raises:
        UserError: The file cannot be read, an option is not valid, or the picture cannot be written.
    """
    path = Path(path)
    if preview is not None:
        check_preview(Path(preview), overwrite=overwrite)
    spec = _make_spec(
        path=str(path),
        splat_encoding=splat_encoding,
        opacity_threshold=opacity_threshold,
        parts=tuple(parts),
    )
    card, found = load_card(path), _choose_kind(kind, load_card(path), path)
    loaded = load_as_it_lies(spec.object, ".")  # what is warned of is among the notes
    pictured = up is None and is_photo(path)
    chosen = (
        UPRIGHT if pictured else choose_up(spec.object.model_copy(update=dict(up=up)), card, loaded, Path())
    )
    choice = spec.object.model_copy(update=dict(up=chosen.axis, kind=found.kind))
    inspection = Inspection(
        path=str(path),
        **_describe_content(path, loaded),
        up=chosen,
        kind=found,
        command=_make_command(choice, found),
    )
    run = resolve(spec.model_copy(update=dict(object=choice)))
    body, plan = _plan(run, inspection)
    inspection = inspection.model_copy(update=plan)
    known = () if body is None else make_brief(run.template, parts=body.parts).parts
    if body is not None:
        inspection = inspection.model_copy(update=dict(parts=_describe_parts(body, known)))
    if preview is not None:
        source, domain = run.template.source, run.template.preset.domain
        if body is None:
            cloud, placement = place(loaded.cloud, source, domain, loaded.origin)
            owner = None
        else:
            cloud, placement, owner = body.cloud, body.placement, find_owners(body, known)
        label = f"up = {chosen.axis}{'' if chosen.known else ' ?'}"
        picture = draw_preview(cloud, placement, run.template.camera, domain, label, owner)
        write_preview(Path(preview), picture, overwrite=overwrite)
        inspection = inspection.model_copy(update=dict(preview=str(preview)))
    return inspection


def _make_spec(**options: object) -> RunSpec:
    try:
        return RunSpec.model_validate(dict(object=options, prompt=SENTENCE))
    except ValidationError as error:
        raise format_validation_error(error, "arguments", RunSpec) from None


def _describe_parts(body: Body, parts: Sequence[Part]) -> tuple[FoundPart, ...]:
    source, volume = body.placement.to_source(body.particles.x), np.asarray(body.particles.volume, float)
    return tuple(
        FoundPart(
            number=number,
            label=part.label,
            origin=part.origin,
            confidence=part.confidence,
            share=round(float(volume[mask].sum() / volume.sum()), 4),
            low=tuple(source[mask].min(0).tolist()),
            high=tuple(source[mask].max(0).tolist()),
        )
        for number, (part, mask) in enumerate(zip(parts, find_masks(body, parts)), 1)
    )


def _describe_content(path: Path, loaded: LoadedSplats) -> dict[str, Any]:
    """The fields of `Inspection` that the file alone decides."""
    facts = dict(format=loaded.format_name, encoding=loaded.encoding, notes=loaded.notes)
    facts |= dict(degenerate=diagnose_cloud(loaded.cloud))
    if not is_photo(path) and find_format(read_head(path), path) is None:
        mesh = read_mesh(path)
        count = len(mesh.faces)
        facts |= dict(encoding="", content="triangles", kept=count)
        low, high = mesh.bounds
    else:
        points = np.asarray(loaded.cloud.means, np.float64) + loaded.origin
        low, high, count = points.min(0), points.max(0), loaded.count_in_file
        facts |= dict(content="Gaussians", kept=loaded.cloud.count)
        facts |= dict(origin=tuple(loaded.origin.tolist()) if loaded.origin.any() else None)
    corners = {
        name: tuple(each.tolist()) for name, each in dict(low=low, high=high, extent=high - low).items()
    }
    return {**facts, **corners, "count": count}


def _choose_kind(given: str | None, card: ObjectCard, path: Path) -> Kind:
    """The kind as a run has it, with the reason."""
    if given is not None:
        return Kind(kind=find_kind(given, "`--kind`"), known=True, reason="it was given")
    if card.kind is not None:
        return Kind(kind=card.kind, known=True, reason="the card beside the file says so")
    name = card.name or path.stem.replace("_", " ")
    kind = guess_kind(name)
    if kind != UNKNOWN:
        return Kind(kind=kind, known=True, reason=f"by the name {shorten(name)!r}")
    kinds = ", ".join(each for each in PRIORS if each != UNKNOWN)
    return Kind(
        kind=kind, known=False, reason=f"the name {shorten(name)!r} tells none; choose one of {kinds}"
    )


def _plan(run: ResolvedRun, seen: Inspection) -> tuple[Body | None, dict[str, Any]]:
    """The object at rest, None if it cannot be made, and the fields of `Inspection` on what a run makes of it."""
    preset, template = run.template.preset, run.template
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        try:
            body = make_body(template.source, preset.filling, preset.domain, run.base_dir)
            template, changed = run.place(body)
            config = fuse(template, body, ForceField())
        except UserError as error:
            return None, dict(refusal=str(error), notes=_collect(seen, run.warnings, caught))
    cost, refusal = estimate_cost(config, body, run.spec.save.video_size), None
    try:
        check_cost(cost, Limits())
    except UserError as error:
        refusal = str(error)
    pieces = tuple(Piece(share=each.share, distance=each.distance) for each in body.loose)
    planned = PlannedRun(
        preset=run.spec.preset.value,
        particles=body.particles.count,
        cells=preset.domain.cells,
        object_cells=body.extent / preset.domain.dx,
        frames=preset.timing.frame_count,
        substeps=round(cost.substeps),
        seconds=cost.seconds,
        memory=cost.memory,
    )
    notes = _collect(seen, (*run.warnings, *changed), caught)
    notes = tuple(each for each in notes if each != explain_loose(body.loose))
    return body, dict(run=planned, refusal=refusal, pieces=pieces, notes=notes)


def _collect(seen: Inspection, more: tuple[str, ...], caught: list) -> tuple[str, ...]:
    """All notes, each once; those on degenerate Gaussians have a place of their own."""
    notes = dict.fromkeys((*seen.notes, *more, *(str(each.message) for each in caught)))
    return tuple(each for each in notes if each not in seen.degenerate)


def _make_command(choice: ObjectChoice, kind: Kind) -> str:
    """The command line of a run with what was found."""
    stem = Path(choice.path).name.split(".")[0]
    pictured = is_photo(Path(choice.path))
    options: list[object] = (
        ["--image", choice.path] if pictured else ["--object", choice.path, "--up", choice.up]
    )
    options += ["--kind", kind.kind] if kind.known else []
    default = ObjectChoice.model_fields["opacity_threshold"].default
    if choice.opacity_threshold != default:
        options += ["--opacity-threshold", choice.opacity_threshold]
    if choice.splat_encoding is not None:
        options += ["--splat-encoding", choice.splat_encoding]
    options += [word for each in choice.parts for word in ("--part", each.format())]
    options += ["--prompt", SENTENCE, "--out", f"runs/{stem}"]
    return shlex.join(["physagent", "run", *map(str, options)])
