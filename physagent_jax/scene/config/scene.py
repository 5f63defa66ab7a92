"""`SceneConfig`: one JSON file that holds everything a simulation needs; replayable, versioned, strict.

SI units (m, s, kg, Pa). The world is z-up and the domain is [0, domain.size]^3; the object is rotated so
that its own up axis points along +z, scaled so that its longest side is ``source.extent`` and centred.
Regions of constraints are absolute [m] and select particles by their rest position.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from physagent_jax.core.strict import Strict
from physagent_jax.forces.schema import ForceField, SkillScaling
from physagent_jax.scene.config.boundaries import Boundary, DomainBox, Mesh
from physagent_jax.scene.config.common import Acceleration
from physagent_jax.scene.config.constraints import Anchor, Constraint
from physagent_jax.scene.config.forces import ForceTerm
from physagent_jax.scene.config.material import Bearing, Material, MaterialRegion
from physagent_jax.scene.config.numerics import Domain, Timing, Transfer
from physagent_jax.scene.config.rendering import CameraConfig, Rendering
from physagent_jax.scene.config.source import Filling, Source

_FEW = Field(max_length=256)  # every one of them is compiled into the step


class SceneConfig(Strict):
    """The fused configuration (the paper's Theta): the object, its material, its surroundings, the forces.

    Attributes:
        version: Format version.
        prompt: The sentence, for the record.
        preset: Name of the preset that gave the defaults, for the record.
        bearing: What makes parts of it stiffer than its material; None = nothing.
        gravity: [m/s^2]; acts only if ``force_field.default_drop``, or ``always_gravity``.
        always_gravity: Whether gravity acts regardless of the force field.
        start: "unstressed": the captured pose bears nothing yet, and sags where gravity acts; "equilibrium": it
            bears the object's weight, as it did when it was captured (`scene.compile.equilibrium`).
        forces: Terms that act besides the force field; the agents neither see nor change them.
        ledger: Whether work, dissipation and impulses are recorded frame by frame (`mpm.ledger`).
        scaling: None = the closed forms of `forces.scaling`, evaluated when the scene is compiled.
    """

    version: Literal[1] = 1
    prompt: str = ""
    preset: str = "fast"
    source: Source
    filling: Filling = Filling()
    material: Material = Material()
    bearing: Bearing | None = None
    material_regions: Annotated[tuple[MaterialRegion, ...], _FEW] = ()
    domain: Domain = Domain()
    timing: Timing = Timing()
    transfer: Transfer = Transfer()
    gravity: Acceleration = (0.0, 0.0, -9.8)
    always_gravity: bool = False
    start: Literal["unstressed", "equilibrium"] = "unstressed"
    boundaries: Annotated[tuple[Boundary, ...], _FEW] = (DomainBox(),)
    constraints: Annotated[tuple[Constraint, ...], _FEW] = ()
    anchor: Anchor = Anchor()
    force_field: ForceField = ForceField()
    forces: Annotated[tuple[ForceTerm, ...], _FEW] = ()
    scaling: SkillScaling | None = None
    ledger: bool = False
    camera: CameraConfig = CameraConfig()
    rendering: Rendering = Rendering()

    def files(self, base_dir: Path) -> dict[str, Path]:
        """The files that the scene names, by what they are for; relative paths start from ``base_dir``."""
        names = {"object": self.source.path}
        if self.anchor.kind == "mask" and self.anchor.mask_path is not None:
            names["anchor"] = self.anchor.mask_path
        for index, boundary in enumerate(self.boundaries):
            if isinstance(boundary, Mesh):
                names[f"boundaries[{index}]"] = boundary.path
        return {name: base_dir / path for name, path in names.items()}
