"""From the command line's options to a `synthesis.Request`."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pydantic import ValidationError

from physagent_jax.agents.rules.executor import RuleExecutor
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.rules.semantic import RuleSemanticAgent
from physagent_jax.cli.matter import chosen_material
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_regular, validation_message
from physagent_jax.core.strict import Strict
from physagent_jax.run.loop import Agents, Request
from physagent_jax.run.manifest import MOST_ROUNDS
from physagent_jax.run.provenance import make_manifest, settings_hash
from physagent_jax.scene.anchor import MASK_BYTES
from physagent_jax.scene.card import load_card
from physagent_jax.scene.config import Anchor, CameraConfig, Source
from physagent_jax.scene.config.common import Friction
from physagent_jax.scene.cost import Limits
from physagent_jax.scene.fuse import Ingredients
from physagent_jax.scene.load import file_sha256
from physagent_jax.scene.presets import PRESETS, Preset
from physagent_jax.scene.priors import anchor_for, damping_for, find_kind, guess_kind

if TYPE_CHECKING:
    from physagent_jax.cli.run import Run


Held = Literal["base", "top", "none"] | None
"""What a sentence says about being held."""


def offline_agents() -> Agents:
    """The deterministic agents: no model, no network."""
    return Agents(RuleSemanticAgent(), RulePlanner(), RuleExecutor())


def make_request(command: Run, command_line: str) -> Request:
    """Gathers everything that the loop needs.

    Raises:
        UserError: The object file is missing or an option is out of range.
    """
    path = command.object
    check_options(command)
    sha256 = file_sha256(path)
    card = load_card(path)
    name = card.name or path.stem.replace("_", " ")
    kind = card.kind or guess_kind(name)
    if command.kind is not None:
        kind = find_kind(command.kind, "`--kind`")
    warnings: list[str] = []
    try:
        preset = preset_of(command)
        source = Source(
            path=str(path.resolve()),
            sha256=sha256,
            name=name,
            kind=kind,
            up=command.up or card.up or "+z",
            opacity_threshold=command.opacity_threshold,
        )
        ingredients = Ingredients(
            prompt=command.prompt,
            preset_name=command.preset.value,
            preset=preset,
            source=source,
            material=chosen_material(command, kind, preset, warnings),
            anchor=_anchor(command, kind),
            camera=_camera(command, card.azimuth_degrees),
            friction=_Ground(friction=command.friction).friction,
            damping_rate=damping_for(kind),
            ledger=command.ledger,
        )
    except ValidationError as error:
        raise validation_message(
            error, "command line", do="`physagent run --help` lists the options"
        ) from None
    inputs = {"object": sha256, "settings": settings_hash(_settings(command, ingredients))}
    manifest = make_manifest(command=command_line, prompt=command.prompt, seed=command.seed, inputs=inputs)
    if command.up is None and card.up is None:
        assumed = (
            "the file's up axis is not known: +z assumed; pass --up if the object lies or stands on its head"
        )
        warnings.append(assumed)
    manifest = manifest.model_copy(update=dict(warnings=tuple(warnings)))
    return Request(
        prompt=command.prompt,
        ingredients=ingredients,
        choose_anchor=lambda asked, words: _anchor(command, kind, asked, words),
        base_dir=Path.cwd(),
        out=command.out,
        manifest=manifest,
        limits=Limits(command.max_minutes, command.max_memory),
        needed=tuple(filter(None, (path, command.anchor_mask, command.physgm))),
        max_iterations=command.max_iterations,
        probe=command.probe,
        overwrite=command.overwrite,
        save_frames=command.save_frames,
        save_splats=command.save_splats,
    )


class _Ground(Strict):
    """What is said about the ground, which only a scene with one has a schema for."""

    friction: Friction


def check_options(command: Run) -> None:
    """Refuses options that exclude each other, or that mean nothing without another.

    Raises:
        UserError: There is such a pair.
    """
    if not 1 <= command.max_iterations <= MOST_ROUNDS:
        rounds = f"must be at least 1 and at most {MOST_ROUNDS}"
        raise UserError(f"`--max-iterations` {rounds}", got=command.max_iterations)
    for kind in ("box", "mask"):
        given = getattr(command, f"anchor_{kind}") is not None
        if given and command.anchor != kind:
            raise UserError(
                f"`--anchor-{kind}` means nothing without `--anchor {kind}`",
                got=f"--anchor {command.anchor}",
                do=f"Pass `--anchor {kind}`, or leave `--anchor-{kind}` out",
            )
    if command.anchor == "box" and command.anchor_box is None:
        raise UserError("`--anchor box` needs a box", do="Pass --anchor-box x y z hx hy hz")
    if command.anchor == "mask":
        if command.anchor_mask is None:
            raise UserError("`--anchor mask` needs a mask", do="Pass --anchor-mask mask.npy")
        check_regular(command.anchor_mask, most=MASK_BYTES, what="the anchor mask")


def _anchor(command: Run, kind: str, asked: Held = None, words: str = "") -> Anchor:
    if command.anchor == "auto":
        return anchor_for(kind, asked, words)
    reason = "set on the command line"
    if command.anchor == "box":
        assert command.anchor_box is not None  # `check_options`
        x, y, z, hx, hy, hz = command.anchor_box
        return Anchor(kind="box", point=(x, y, z), half_size=(hx, hy, hz), reason=reason)
    if command.anchor == "mask":
        assert command.anchor_mask is not None
        return Anchor(kind="mask", mask_path=str(command.anchor_mask.resolve()), reason=reason)
    return anchor_for(kind, command.anchor).model_copy(update=dict(reason=reason))


def _camera(command: Run, azimuth: float | None) -> CameraConfig:
    if command.azimuth is not None:
        azimuth = command.azimuth
    return CameraConfig(azimuth_degrees=azimuth or 0.0, elevation_degrees=command.elevation)


def _settings(command: Run, ingredients: Ingredients) -> dict:
    """What makes two runs the same; where the object lies on the disk is not part of it."""
    parts = {
        "preset": {name: getattr(ingredients.preset, name).model_dump(mode="json") for name in _PRESET_PARTS},
        "source": ingredients.source.model_dump(mode="json", exclude={"path"}),
        "material": ingredients.material.model_dump(mode="json"),
        "camera": ingredients.camera.model_dump(mode="json"),
        "anchor": ingredients.anchor.model_dump(mode="json"),
    }
    options = (command.prompt, command.anchor, command.friction, ingredients.damping_rate)
    options = (*options, command.max_iterations, command.seed)
    probe = (
        {"probe": True} if command.probe else {}
    )  # without it, runs of earlier versions are still the same
    return {**parts, "options": options, "save": (command.save_frames, command.save_splats), **probe}


_PRESET_PARTS = ("domain", "filling", "timing", "transfer", "rendering")


def preset_of(command: Run) -> Preset:
    """The chosen preset with the command line's changes."""
    preset = PRESETS[command.preset]
    changes = {
        "timing": {"frame_count": command.frames},
        "filling": {"max_particles": command.particles, "seed": command.seed},
        "rendering": {"width": command.resolution, "height": command.resolution},
    }
    for part, values in changes.items():
        given = {key: value for key, value in values.items() if value is not None}
        if given:
            old = getattr(preset, part)
            preset = dataclasses.replace(preset, **{part: _validated(old, given)})
    return preset


def _validated(model, changes: dict):
    try:
        return type(model).model_validate({**model.model_dump(), **changes})
    except ValidationError as error:
        raise validation_message(
            error, "command line", do="`physagent run --help` lists the options"
        ) from None
