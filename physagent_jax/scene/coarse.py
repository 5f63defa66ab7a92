"""A coarse version of a scene: cheap enough to try force fields on before they are simulated in earnest."""

from __future__ import annotations

import dataclasses

from physagent_jax.core.errors import UserError
from physagent_jax.scene.body import Body
from physagent_jax.scene.presets import Preset

COARSER = 2  # times longer cells; steps grow as much, so that simulating costs a sixteenth or less
FEWEST_CELLS = 8  # along the object's longest side; fewer hold no shape that a force could bend
FEWEST_PARTICLES = 200
PICTURE_SHARE = 1 / 3  # of the sides
SMALLEST_PICTURE = 96  # [px], shorter side; in smaller ones nothing can be followed


def coarsen(preset: Preset, body: Body) -> Preset:
    """The settings with `COARSER` times longer cells, as many particles per cell, and smaller pictures.

    The clip stays as it is, because force fields count in its frames. The step is chosen anew: what was right for the
    fine grid would be shorter than need be.

    Args:
        preset: The settings in earnest.
        body: The object as they fill it.

    Raises:
        UserError: Too little of the object would be left.
    """
    cells = preset.domain.cells // COARSER
    across = body.extent * cells / preset.domain.size
    particles = body.particles.count // COARSER**3
    if across < FEWEST_CELLS or particles < FEWEST_PARTICLES:
        raise UserError(
            "the object is too coarse already to be probed",
            got=f"{across:.3g} cells across it and {particles} particles, with {FEWEST_CELLS} and "
            f"{FEWEST_PARTICLES} needed",
        )
    filling, picture = preset.filling, preset.rendering
    own_cells = None if filling.cells is None else max(4, filling.cells // COARSER)
    share = min(1.0, max(PICTURE_SHARE, SMALLEST_PICTURE / min(picture.width, picture.height)))
    return dataclasses.replace(
        preset,
        domain=preset.domain.model_copy(update=dict(cells=cells)),
        filling=filling.model_copy(update=dict(max_particles=particles, cells=own_cells)),
        timing=preset.timing.model_copy(update=dict(substep_dt="auto", force_substep=False)),
        rendering=picture.model_copy(
            update=dict(width=round(share * picture.width), height=round(share * picture.height))
        ),
    )
