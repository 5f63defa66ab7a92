"""What `physagent run` makes the object of: the kind's prior, a named material, or PhysGM's prediction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import nearest
from physagent_jax.core.reading import read_json
from physagent_jax.scene.config import Material, MaterialModel
from physagent_jax.scene.config.material import WITHOUT_STRESS
from physagent_jax.scene.materials import LIBRARY, find_material, softened, stable_step, substeps
from physagent_jax.scene.materials.soften import softening_for
from physagent_jax.scene.physgm import import_physgm
from physagent_jax.scene.presets import Preset
from physagent_jax.scene.priors import material_for

if TYPE_CHECKING:
    from physagent_jax.cli.run import Run

AFFORDABLE = 10_000  # substeps of a clip that `--soften auto` aims at
EXPENSIVE = 100_000  # substeps of a clip beyond which a warning is due; usual runs take some thousands


def chosen_material(command: Run, kind: str, preset: Preset, warnings: list[str]) -> Material:
    """The material of a run, by its options; what the user should know is added to ``warnings``.

    Raises:
        UserError: An unknown name, an unreadable prediction, or options that exclude each other.
        pydantic.ValidationError: An option is out of range.
    """
    material = _with_options(command, _base(command, kind, warnings))
    dx = preset.domain.dx
    duration = (preset.timing.frame_count - 1) * preset.timing.frame_dt
    if command.soften == "auto":
        factor = softening_for(material, dx=dx, duration=duration, at_most=AFFORDABLE)
        material = softened(material, factor)
    elif command.soften is not None:
        material = softened(material, command.soften)
    if preset.timing.substep_dt == "auto":
        _warn_of_cost(material, dx, duration, warnings)
    return material


def _base(command: Run, kind: str, warnings: list[str]) -> Material:
    if command.physgm is not None:
        if command.material is not None:
            raise UserError(
                "`--physgm` and `--material` both say what the object is made of", do="Pass one of them"
            )
        material, notes = import_physgm(
            read_json(command.physgm, what="PhysGM's prediction"), warn_of_cost=False
        )
        warnings += notes
        return material
    if command.material is None:
        return material_for(kind)
    models = [model.value for model in MaterialModel]
    try:
        return find_material(command.material).material
    except UserError as error:
        if command.material in models:
            return _of_model(MaterialModel(command.material), material_for(kind))
        model = nearest(command.material, [m for m in models if m not in LIBRARY], count=1)
        hint = f"Or the constitutive model {model[0]}? " if model else ""
        raise UserError(f"`--material`: {error.what}", got=error.got, do=f"{hint}{error.do}") from None


def _of_model(model: MaterialModel, prior: Material) -> Material:
    """A kind's values under another law."""
    try:
        return prior.changed(model=model, reason=f"{model} from the command line, the rest: {prior.reason}")
    except ValidationError as error:
        missing = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise UserError(
            f"`--material {model}`: {missing}, which a kind does not tell",
            do="Pass a named material of that model (`physagent materials`), or write it into a scene file",
        ) from None


def _with_options(command: Run, material: Material) -> Material:
    options = {
        "youngs_modulus": command.youngs_modulus,
        "poissons_ratio": command.poissons_ratio,
        "density": command.density,
    }
    given = {key: value for key, value in options.items() if value is not None}
    if not given:
        return material
    idle = [key for key in given if key != "density" and material.model in WITHOUT_STRESS]
    if idle:
        options = ", ".join(f"`--{key.replace('_', '-')}`" for key in idle)
        raise UserError(
            f"{options}: a {material.model} body has no stiffness",
            do="Leave it out, or choose another material",
        )
    reason = f"{', '.join(given)} from the command line, the rest: {material.reason}"
    return material.changed(**given, reason=reason)


def _warn_of_cost(material: Material, dx: float, duration: float, warnings: list[str]) -> None:
    many = substeps(material, dx, duration)
    if many <= EXPENSIVE:
        return
    try:
        remedy = f"--soften {softening_for(material, dx=dx, duration=duration, at_most=AFFORDABLE):g}"
        remedy += f" brings it to {AFFORDABLE:,}, with the same strains at yield"
    except UserError as error:
        remedy = str(error)
    warnings.append(
        f"this material allows substeps of {stable_step(material, dx):.2g} s, so that a round takes at least "
        f"{many:,} of them: {remedy}"
    )
