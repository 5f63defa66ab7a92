"""Material parameters per particle, and the blocks of equal model."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np

from physagent_jax.mpm import FixedCorotated, NeoHookean, lame_parameters
from physagent_jax.scene import config as c
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile.select import DTYPE, in_box

MODELS = {c.MaterialModel.NEO_HOOKEAN: NeoHookean, c.MaterialModel.FIXED_COROTATED: FixedCorotated}


@dataclasses.dataclass(frozen=True)
class Matter:
    """Material parameters per particle."""

    model: np.ndarray
    youngs_modulus: np.ndarray
    poissons_ratio: np.ndarray
    density: np.ndarray

    @staticmethod
    def of(config: c.SceneConfig, body: Body) -> Matter:
        """The parameters of every particle of ``body``, in its order."""
        names = list(MODELS)
        count, rest = body.particles.count, body.particles.x

        def spread(material: c.Material):
            return (
                names.index(material.model),
                material.youngs_modulus,
                material.poissons_ratio,
                material.density,
            )

        columns = [np.full(count, value) for value in spread(config.material)]
        for index, region in enumerate(config.material_regions):
            inside = in_box(rest, region, f"material_regions[{index}]")
            for column, value in zip(columns, spread(region.material)):
                column[inside] = value
        return Matter(*columns)

    def take(self, order: np.ndarray) -> Matter:
        """The same in another order."""
        return Matter(*(getattr(self, f.name)[order] for f in dataclasses.fields(self)))

    def materials(self) -> tuple:
        """One material per block of equal model; the particles must be in order."""
        blocks = []
        for index, solid in enumerate(MODELS.values()):
            block = self.model == index
            if block.any():
                mu, lam = lame_parameters(self.youngs_modulus[block], self.poissons_ratio[block])
                blocks.append(solid(jnp.asarray(mu, DTYPE), jnp.asarray(lam, DTYPE)))
        return tuple(blocks)
