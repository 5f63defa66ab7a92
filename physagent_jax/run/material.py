"""The material of a run's object: the kind's prior, a named material, the sentence's, or PhysGM's prediction."""

from __future__ import annotations

import math
from pathlib import Path

from pydantic import ValidationError

from physagent_jax.agents.grammar.tables import get_set
from physagent_jax.core.errors import UserError
from physagent_jax.core.names import find_nearest
from physagent_jax.core.reading import read_json
from physagent_jax.run.spec import MaterialChoice
from physagent_jax.scene.config import Material, MaterialModel, Source
from physagent_jax.scene.config.material import MODEL_PARAMETERS, WITHOUT_STRESS
from physagent_jax.scene.materials import LIBRARY, count_substeps, find_material, soften_material, stable_step
from physagent_jax.scene.materials.soften import (
    explain_softening,
    find_contrast,
    find_softening,
    limit_poissons_ratio,
)
from physagent_jax.scene.physgm import import_physgm
from physagent_jax.scene.presets import Preset
from physagent_jax.scene.priors import PRIORS, UNKNOWN, choose_material, find_hard_kind

AFFORDABLE = 10_000  # substeps of a clip that `--soften_material auto` aims at
_SHORT = 2.0  # [s] of a clip that may take no more, where the sentence chooses the matter; longer ones by their root
_VALUES = ("youngs_modulus", "poissons_ratio", "density", "damping_ratio")
EXPENSIVE = 100_000  # substeps of a clip beyond which a warning is due; usual runs take some thousands


def find_matter(source: Source, prompt: str) -> str:
    """The kind that an object's matter is of: its own, or the hard one that its name or the sentence tells.

    Args:
        source: The object.
        prompt: The sentence.
    """
    if source.kind != UNKNOWN:
        return source.kind
    return find_hard_kind(source.name or "", prompt, others=get_set("persons")) or source.kind


def resolve_material(
    choice: MaterialChoice, kind: str, preset: Preset, *, base_dir: str | Path = ".", said: str | None = None
) -> tuple[Material, tuple[str, ...]]:
    """The material that is chosen for an object of ``kind``, and what the user should know of it.

    Args:
        choice: The user's choice.
        kind: The object's kind.
        preset: Grid and clip, which decide what a stiff material costs.
        base_dir: Folder that a relative path starts from.
        said: Kind or library entry that the sentence chooses; of a true, stiff material it takes a softer stand-in,
            so that a round is affordable. None = it says nothing.

    Raises:
        UserError: An unknown name, an unreadable prediction, or a stiffness for what has none.
        pydantic.ValidationError: A value is out of range.
    """
    warnings: list[str] = []
    if said in PRIORS:
        kind, said = said, None
    material = _apply_values(choice, _choose_base(choice, kind, Path(base_dir), warnings, said))
    dx = preset.domain.dx
    duration = (preset.timing.frame_count - 1) * preset.timing.frame_dt
    hard = material
    if choice.soften == "auto" or (choice.soften is None and said is not None):
        find = find_softening if choice.soften == "auto" else find_contrast
        # With the same number for ten seconds, rubber would be 25 times as soft as in two, and sag.
        longer = 1.0 if choice.soften == "auto" else math.sqrt(max(duration / _SHORT, 1.0))
        most = round(longer * AFFORDABLE)
        material = soften_material(material, find(material, dx=dx, duration=duration, at_most=most))
        if choice.soften is None and choice.poissons_ratio is None:
            material = limit_poissons_ratio(material)
    elif choice.soften is not None:
        material = soften_material(material, choice.soften)
    if (seen := explain_softening(hard, material)) is not None:
        warnings.append(seen)
    if preset.timing.substep_dt == "auto":
        _warn_of_cost(material, dx, duration, warnings)
    return material, tuple(warnings)


def _choose_base(
    choice: MaterialChoice, kind: str, base_dir: Path, warnings: list[str], said: str | None
) -> Material:
    if choice.physgm is not None:
        prediction = read_json(base_dir / choice.physgm, what="PhysGM's prediction")
        material, notes = import_physgm(prediction, warn_of_cost=False)
        warnings += notes
        return material
    if choice.name is None:
        return choose_material(kind) if said is None else find_material(said).material
    models = [model.value for model in MaterialModel]
    try:
        return find_material(choice.name).material
    except UserError as error:
        if choice.name in models:
            return _choose_of_model(MaterialModel(choice.name), choose_material(kind))
        model = find_nearest(choice.name, [m for m in models if m not in LIBRARY], count=1)
        hint = f"Or the constitutive model {model[0]}? " if model else ""
        raise UserError(f"`material.name`: {error.what}", got=error.got, do=f"{hint}{error.do}") from None


def _choose_of_model(model: MaterialModel, prior: Material) -> Material:
    """A kind's values under another law."""
    try:
        return prior.changed(model=model, reason=f"{model} was chosen, the rest: {prior.reason}")
    except ValidationError as error:
        missing = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise UserError(
            f"`material.name` {model}: {missing}, which a kind does not tell",
            do="Give a named material of that model (`physagent materials`), or write it into a scene file",
        ) from None


def _apply_values(choice: MaterialChoice, material: Material) -> Material:
    """The material with the values that are chosen one by one."""
    values = {name: getattr(choice, name) for name in _VALUES}
    given = {name: value for name, value in values.items() if value is not None}
    if not given:
        return material
    idle = [name for name in given if name != "density" and material.model in WITHOUT_STRESS]
    if idle:
        raise UserError(
            f"{', '.join(f'`material.{name}`' for name in idle)}: a {material.model} body has no stiffness",
            do="Leave it out, or choose another material",
        )
    if "damping_ratio" in given and "damping_ratio" not in MODEL_PARAMETERS[material.model]:
        raise UserError(
            f"`material.damping_ratio`: what {material.model} does to motion is not a damping ratio",
            do="Leave it out, or choose an elastic material",
        )
    reason = f"{', '.join(given)} chosen, the rest: {material.reason}"
    return material.changed(**given, reason=reason)


def _warn_of_cost(material: Material, dx: float, duration: float, warnings: list[str]) -> None:
    many = count_substeps(material, dx, duration)
    if many <= EXPENSIVE:
        return
    try:
        remedy = (
            f"`material.soften` {find_softening(material, dx=dx, duration=duration, at_most=AFFORDABLE):g}"
        )
        remedy += f" brings it to {AFFORDABLE:,}, with the same strains at yield"
    except UserError as error:
        remedy = str(error)
    warnings.append(
        f"this material allows substeps of {stable_step(material, dx):.2g} s, so that a round takes at least "
        f"{many:,} of them: {remedy}"
    )
