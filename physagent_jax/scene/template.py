"""A scene without its force field: what all rounds of a run share."""

from __future__ import annotations

import dataclasses

from physagent_jax.scene.config import Anchor, Bearing, CameraConfig, Material, Source
from physagent_jax.scene.presets import Preset
from physagent_jax.scene.world import FREE, World


@dataclasses.dataclass(frozen=True)
class SceneTemplate:
    """A scene without its force field; the same for all rounds of a run.

    Attributes:
        prompt: The sentence, for the record.
        preset_name, preset: Grid, particles, time, transfer, pictures.
        source: The object.
        material: What it is made of.
        anchor: What is held.
        camera: Direction and lens; with ``target`` None it is placed to show the expected motion.
        world: What surrounds the object.
        friction: Friction of ground and obstacles.
        bearing: What makes parts of it stiffer than the material; None = nothing.
        damping_rate: Drag of the surrounding air [1/s]; the preset's holds if it is larger.
        damping_ratio: Damping ratio of what nobody has chosen one for (`Material.damping_ratio`), as far as it
            costs few substeps.
        damping_kind: Kind that the material and ``damping_ratio`` are of; None = the object's.
        ledger: Whether exchanged energy and momentum are recorded.
    """

    prompt: str
    preset_name: str
    preset: Preset
    source: Source
    material: Material
    anchor: Anchor
    camera: CameraConfig
    world: World = FREE
    friction: float = 0.0
    bearing: Bearing | None = None
    damping_rate: float = 0.0
    damping_ratio: float = 0.0
    damping_kind: str | None = None
    ledger: bool = False

    @property
    def matter(self) -> str:
        """The kind that its matter is of."""
        return self.damping_kind or self.source.kind
