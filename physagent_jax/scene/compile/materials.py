"""The material of every particle, and the simulator's blocks of equal model."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.core.errors import UserError
from physagent_jax.mpm import materials as m
from physagent_jax.mpm.numbers import cast
from physagent_jax.scene import config as c
from physagent_jax.scene.body import Body
from physagent_jax.scene.burden import find_firmness
from physagent_jax.scene.compile.idle import SOFT
from physagent_jax.scene.compile.select import DTYPE, select_box
from physagent_jax.scene.damping import Mode, compute_viscosity
from physagent_jax.scene.fragments import FIRM, count_fragments, find_seams

SEAM = 2.0
"""Cells of the weak layer between two fragments."""
_ORDER = {model: rank for rank, model in enumerate(c.MaterialModel)}


@dataclasses.dataclass(frozen=True)
class ParticleMaterials:
    """The configured materials and who has which.

    Attributes:
        choices: The scene's material, then those of its regions.
        choice: Index into ``choices``, shape (n,).
        firmness: Factors of Young's modulus that bear the object's weight (`scene.burden`), shape (n,); None = 1.
        numbers: For each of ``choices`` what it has in place of its own numbers, by name: scalars, or one per particle,
            shape (n,), traced or not.
        dtype: Type of what is built.
    """

    choices: tuple[c.Material, ...]
    choice: np.ndarray
    firmness: np.ndarray | None = None
    numbers: tuple[Mapping[str, Any], ...] = ()
    dtype: Any = DTYPE

    @staticmethod
    def of(config: c.SceneConfig, body: Body) -> ParticleMaterials:
        """The materials of the particles of ``body``, in its order; a later region wins where two overlap.

        Raises:
            UserError: A region holds no particle.
        """
        choice = np.zeros(body.particles.count, np.int32)
        for index, region in enumerate(config.material_regions):
            choice[select_box(body.particles.x, region, f"material_regions[{index}]")] = index + 1
        choices = (config.material, *(region.material for region in config.material_regions))
        numbers = tuple(
            _find_strength(each, choice == index, body, config) for index, each in enumerate(choices)
        )
        firmness = find_firmness(body, config.material, config.anchor, config.bearing, dx=config.domain.dx)
        return ParticleMaterials(choices, choice, firmness, numbers if any(numbers) else ())

    def permute(self, order: np.ndarray) -> ParticleMaterials:
        """The same in another order."""
        numbers = tuple(
            {name: value[order] if np.ndim(value) else value for name, value in each.items()}
            for each in self.numbers
        )
        firmness = None if self.firmness is None else self.firmness[order]
        return dataclasses.replace(self, choice=self.choice[order], firmness=firmness, numbers=numbers)

    def soften(self, idle: np.ndarray) -> ParticleMaterials:
        """The same with next to no stiffness of ``idle`` particles, shape (n,)."""
        firmness = np.ones(len(idle)) if self.firmness is None else self.firmness
        return dataclasses.replace(self, firmness=np.where(idle, SOFT * firmness, firmness))

    def with_numbers(self, numbers: Sequence[Mapping[str, Any]], dtype: Any) -> ParticleMaterials:
        """The same with other numbers, one mapping for each of ``choices``; what they do not name is kept.

        Raises:
            UserError: One is neither a scalar nor one per particle.
        """
        for index, each in enumerate(numbers):
            for name, value in each.items():
                if np.shape(value) not in ((), self.choice.shape):
                    raise UserError(
                        f"`parameters.materials[{index}].{name}` must be a scalar or have one number per particle "
                        f"of the model, {len(self.choice)}",
                        got=np.shape(value),
                    )
        before = self.numbers or ({},) * len(self.choices)
        merged = tuple({**one, **other} for one, other in zip(before, numbers))
        return dataclasses.replace(self, numbers=merged, dtype=dtype)

    def get_values(self, name: str) -> Any:
        """A parameter per particle, shape (n,), 0 where the material does not have it; on the host, unless traced."""
        values: list[Any] = [getattr(material, name) or 0.0 for material in self.choices]
        for index, given in enumerate(self.numbers):
            values[index] = given.get(name, values[index])
        if not any(isinstance(value, Tracer) for value in values):
            spread = np.zeros(len(self.choice))
            for index, value in enumerate(values):
                spread = np.where(self.choice == index, np.asarray(value, np.float64), spread)
            return spread
        spread = jnp.zeros(len(self.choice), jnp.result_type(*values))
        for index, value in enumerate(values):
            spread = jnp.where(self.choice == index, value, spread)
        return spread

    def leaf(self, values: Any) -> jax.Array:
        """``values`` as an array of the particles' dtype."""
        return cast(values, self.dtype)

    @property
    def density(self) -> Any:
        """[kg/m^3], shape (n,)."""
        return self.get_values("density")

    @property
    def model(self) -> np.ndarray:
        """A number per particle that is equal within a block, shape (n,): sort by it."""
        # Whether a fluid bears tension is part of its program, so fluids of both kinds are two blocks.
        keys = [2 * _ORDER[material.model] + bool(material.tension) for material in self.choices]
        return np.array(keys)[self.choice]

    def build_materials(self) -> tuple[m.Material, ...]:
        """One material per block of equal `model`; the particles must be in order."""
        blocks = []
        for key in np.unique(self.model):
            block = self.permute(self.model == key)
            first = block.choices[block.choice[0]]
            blocks.append(_BUILDERS[first.model](block, first))
        return tuple(blocks)

    @property
    def damped(self) -> bool:
        """Return whether a damping ratio is given for any of the particles."""
        return bool(self.get_values("damping_ratio").any())

    def viscosity(self, mode: Mode | None = None) -> jax.Array | None:
        """Newtonian viscosity of fluids and damping of solids [Pa s], shape (n,); None if there is none.

        Args:
            mode: The object's lowest mode, in which damping ratios of a free object hold.
        """
        viscosity: Any = self.get_values("viscosity")
        if mode is not None and not mode.held:
            made = [compute_viscosity(each.damping_ratio or 0.0, each, mode) for each in self.choices]
            viscosity = viscosity + np.array(made)[self.choice]
        return self.leaf(viscosity) if viscosity.any() else None

    def find_stationary(self) -> np.ndarray:
        """Particles that never move, shape (n,): a prescribed motion holds them."""
        return self._select_model(c.MaterialModel.STATIONARY)[self.choice]

    def find_rigid_bodies(self) -> tuple[tuple[int, np.ndarray], ...]:
        """Index in ``choices`` and particles, shape (n,), of each rigid body: each rigid entry is one."""
        rigid = np.flatnonzero(self._select_model(c.MaterialModel.RIGID)).tolist()
        bodies = [(index, self.choice == index) for index in rigid]
        return tuple(body for body in bodies if body[1].any())

    def _select_model(self, model: c.MaterialModel) -> np.ndarray:
        return np.array([material.model is model for material in self.choices])


def _make_builder(law: Callable, *names: str) -> Callable[[ParticleMaterials, c.Material], m.Material]:
    """A builder of ``law(mu, lam, ...)`` with the named parameters after the Lame parameters."""

    def build(block: ParticleMaterials, _: c.Material) -> m.Material:
        return law(*_build_lame(block), *(block.leaf(block.get_values(name)) for name in names))

    return build


def _build_lame(block: ParticleMaterials) -> tuple[jax.Array, jax.Array]:
    """Mu and lam [Pa], shapes (n,)."""
    E = block.get_values("youngs_modulus") * (1.0 if block.firmness is None else block.firmness)
    mu, lam = m.lame_parameters(E, block.get_values("poissons_ratio"))
    return block.leaf(mu), block.leaf(lam)


def _find_strength(
    material: c.Material, chosen: np.ndarray, body: Body, config: c.SceneConfig
) -> Mapping[str, Any]:
    """The cohesion of what breaks into fragments, shape (n,): it is weak only between them."""
    if material.fragments is None:
        return {}
    dx = config.domain.dx
    count = count_fragments(material.fragments, float(body.particles.volume[chosen].sum()), dx)
    cohesion = np.full(len(chosen), material.cohesion)
    firm = chosen.copy()
    firm[chosen] = ~find_seams(body.particles.x[chosen], count, SEAM * dx)
    return {"cohesion": np.where(firm, FIRM, 1.0) * cohesion}


def _make_granular_builder(law: Callable) -> Callable[[ParticleMaterials, c.Material], m.Material]:
    def build(block: ParticleMaterials, _: c.Material) -> m.Material:
        degrees = block.get_values("friction_angle")
        angle = jnp.radians(degrees) if isinstance(degrees, Tracer) else np.radians(degrees)
        return law(*_build_lame(block), block.leaf(angle), block.leaf(block.get_values("cohesion")))

    return build


def _build_fluid(block: ParticleMaterials, first: c.Material) -> m.Material:
    return m.Fluid(block.leaf(block.get_values("bulk_modulus")), tension=bool(first.tension))


def _build_rigid(block: ParticleMaterials, _: c.Material) -> m.Material:
    return m.Rigid(len(block.choice))


_BUILDERS: dict[c.MaterialModel, Callable[[ParticleMaterials, c.Material], m.Material]] = {
    c.MaterialModel.NEO_HOOKEAN: _make_builder(m.NeoHookean),
    c.MaterialModel.FIXED_COROTATED: _make_builder(m.FixedCorotated),
    c.MaterialModel.HENCKY: _make_builder(m.Hencky),
    c.MaterialModel.VON_MISES: _make_builder(m.VonMises, "yield_stress", "hardening_modulus"),
    c.MaterialModel.PLASTICINE: _make_builder(m.Plasticine, "yield_stress", "softening_modulus"),
    c.MaterialModel.DRUCKER_PRAGER: _make_granular_builder(m.DruckerPrager),
    c.MaterialModel.BRITTLE: _make_granular_builder(m.Brittle),
    c.MaterialModel.VISCOPLASTIC: _make_builder(m.Viscoplastic, "yield_stress", "plastic_viscosity"),
    c.MaterialModel.SNOW: _make_builder(
        m.Snow,
        "critical_compression",
        "critical_stretch",
        "hardening_coefficient",
        "hardening_cap",
    ),
    c.MaterialModel.FLUID: _build_fluid,
    c.MaterialModel.RIGID: _build_rigid,
    c.MaterialModel.STATIONARY: _build_rigid,
}
