"""Which material every particle is made of, and the simulator's blocks of equal model."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax
import numpy as np

from physagent_jax.mpm import materials as m
from physagent_jax.scene import config as c
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile.select import select_box, to_array
from physagent_jax.scene.damping import Mode, compute_viscosity

_ORDER = {model: rank for rank, model in enumerate(c.MaterialModel)}


@dataclasses.dataclass(frozen=True)
class ParticleMaterials:
    """The configured materials and who has which.

    Attributes:
        choices: The scene's material, then those of its regions.
        choice: Index into ``choices``, shape (n,).
    """

    choices: tuple[c.Material, ...]
    choice: np.ndarray

    @staticmethod
    def of(config: c.SceneConfig, body: Body) -> ParticleMaterials:
        """The materials of the particles of ``body``, in its order; a later region wins where two overlap.

        Raises:
            UserError: A region holds no particle.
        """
        choice = np.zeros(body.particles.count, np.int32)
        for index, region in enumerate(config.material_regions):
            choice[select_box(body.particles.x, region, f"material_regions[{index}]")] = index + 1
        return ParticleMaterials(
            (config.material, *(region.material for region in config.material_regions)), choice
        )

    def permute(self, order: np.ndarray) -> ParticleMaterials:
        """The same in another order."""
        return ParticleMaterials(self.choices, self.choice[order])

    def get_values(self, name: str) -> np.ndarray:
        """A parameter per particle, shape (n,); 0 where the material does not have it."""
        return np.array([getattr(material, name) or 0.0 for material in self.choices])[self.choice]

    @property
    def density(self) -> np.ndarray:
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
        """Whether a damping ratio is given for any of the particles."""
        return bool(self.get_values("damping_ratio").any())

    def viscosity(self, mode: Mode | None = None) -> jax.Array | None:
        """Newtonian viscosity of fluids and damping of solids [Pa s], shape (n,); None if there is none.

        Args:
            mode: The object's lowest mode, in which damping ratios of a free object hold.
        """
        viscosity = self.get_values("viscosity")
        if mode is not None and not mode.held:
            made = [compute_viscosity(each.damping_ratio or 0.0, each, mode) for each in self.choices]
            viscosity = viscosity + np.array(made)[self.choice]
        return to_array(viscosity) if viscosity.any() else None

    def find_stationary(self) -> np.ndarray:
        """Particles that never move, shape (n,): a prescribed motion holds them."""
        return self._select_model(c.MaterialModel.STATIONARY)[self.choice]

    def find_rigid_bodies(self) -> tuple[np.ndarray, ...]:
        """Particles of each rigid body, shape (n,) each: every rigid entry of ``choices`` is a body of its own."""
        rigid = np.flatnonzero(self._select_model(c.MaterialModel.RIGID))
        masks = [self.choice == index for index in rigid]
        return tuple(mask for mask in masks if mask.any())

    def _select_model(self, model: c.MaterialModel) -> np.ndarray:
        return np.array([material.model is model for material in self.choices])


def _make_builder(law: Callable, *names: str) -> Callable[[ParticleMaterials, c.Material], m.Material]:
    """A builder of ``law(mu, lam, ...)`` with the named parameters after the Lame parameters."""

    def build(block: ParticleMaterials, _: c.Material) -> m.Material:
        lame = m.lame_parameters(block.get_values("youngs_modulus"), block.get_values("poissons_ratio"))
        return law(*map(to_array, lame), *(to_array(block.get_values(name)) for name in names))

    return build


def _build_drucker_prager(block: ParticleMaterials, _: c.Material) -> m.Material:
    mu, lam = m.lame_parameters(block.get_values("youngs_modulus"), block.get_values("poissons_ratio"))
    angle, cohesion = np.radians(block.get_values("friction_angle")), block.get_values("cohesion")
    return m.DruckerPrager(to_array(mu), to_array(lam), to_array(angle), to_array(cohesion))


def _build_fluid(block: ParticleMaterials, first: c.Material) -> m.Material:
    return m.Fluid(to_array(block.get_values("bulk_modulus")), tension=bool(first.tension))


def _build_rigid(block: ParticleMaterials, _: c.Material) -> m.Material:
    return m.Rigid(len(block.choice))


_BUILDERS: dict[c.MaterialModel, Callable[[ParticleMaterials, c.Material], m.Material]] = {
    c.MaterialModel.NEO_HOOKEAN: _make_builder(m.NeoHookean),
    c.MaterialModel.FIXED_COROTATED: _make_builder(m.FixedCorotated),
    c.MaterialModel.HENCKY: _make_builder(m.Hencky),
    c.MaterialModel.VON_MISES: _make_builder(m.VonMises, "yield_stress", "hardening_modulus"),
    c.MaterialModel.PLASTICINE: _make_builder(m.Plasticine, "yield_stress", "softening_modulus"),
    c.MaterialModel.DRUCKER_PRAGER: _build_drucker_prager,
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
