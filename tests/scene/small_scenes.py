"""A jelly of a hundred particles, and scenes that have one of everything."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene import config as c
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.compile import CompiledScene, compile_scene
from physagent_jax.scene.procedural import make_jelly

LOW, HIGH, MIDDLE = 1.1, 1.9, 1.5  # where the jelly is along each axis [m]
FRAME_COUNT, FRAME_DT = 3, 0.05
SOURCE = dict(kind="jelly", extent=HIGH - LOW)

JELLY = c.Material(youngs_modulus=3e4, density=400.0, viscosity=2.0)
SAND = c.Material(
    model=c.MaterialModel.DRUCKER_PRAGER,
    youngs_modulus=2e4,
    friction_angle=32.0,
    cohesion=70.0,
    density=1500.0,
)
METAL = c.Material(
    model=c.MaterialModel.VON_MISES,
    youngs_modulus=4e4,
    yield_stress=300.0,
    hardening_modulus=900.0,
    density=600.0,
)
FIELD = ForceField.model_validate(
    {
        "default_drop": True,
        "actions": [
            {
                "action_type": "translation",
                "vector": [0.3, -0.4, 1],
                "magnitude": 0.8,
                "active_time": [0.4, 1.7],
            }
        ],
        "constraints": [
            {"constraint_type": "particle_impulse", "vector": [0, 1, 1], "active_time": [0.3, 1]}
        ],
    }
)
TERMS = (
    c.Wind(
        direction=(1.0, 0.5, 0.0),
        speed=8.0,
        linear_drag=0.7,
        quadratic_drag=0.2,
        center=(1.5, 1.5, 1.5),
        radius=2.0,
        envelope=c.SineEnvelope(frequency=4.0, phase=0.3, start=0.013, end=0.081),
    ),
    c.Attractor(point=(1.2, 1.4, 2.5), strength=3.0, power=1.0, softening=0.3),
    c.Vortex(point=(1.5, 1.5, 1.5), axis=(0.2, 0.1, 1.0), swirl=6.0, inward=4.0, axial=2.0),
    c.Turbulence(strength=3.0, length_scale=0.4, time_scale=0.2, modes=4),
    c.Uniform(
        acceleration=(1.0, -2.0, 0.5), envelope=c.RampEnvelope(start=0.01, end=0.09, rise=0.02, fall=0.03)
    ),
)
IMPOSED = (
    c.ParticleImpulse(
        point=(1.5, 1.5, 1.8), half_size=(1, 1, 0.2), force=(4.0, 0.0, 1.0), start=0.012, duration=0.03
    ),
    c.ParticleTranslation(
        point=(1.5, 1.5, 1.2),
        half_size=(1, 1, 0.15),
        velocity=(0.3, 0.1, 0.2),
        start=0.06,
        end=0.3,
    ),
)
BOUNDARIES = (
    c.DomainBox(),
    c.HalfSpace(point=(1.5, 1.5, 1.27), normal=(0.0, 0.1, 1.0), friction=0.3),
    c.Sphere(point=(1.5, 1.5, 0.4), radius=0.2, surface=c.Surface.STICKY),
)


def make_small_body(folder: Path) -> Body:
    """The jelly, filled with a hundred particles; its file goes into ``folder``."""
    write_ply(folder / "object.ply", make_jelly(0, count=800))
    config = make_config(folder)
    return make_body(config.source, config.filling, config.domain, folder)


def make_config(
    folder: Path, frame_count: int = FRAME_COUNT, substep_dt: Any = "auto", **parts: Any
) -> c.SceneConfig:
    """A scene of the jelly, alone and without forces but for ``parts``."""
    return c.SceneConfig(
        source=c.Source(path=str(folder / "object.ply"), **SOURCE),
        filling=c.Filling(max_particles=100),
        domain=c.Domain(size=3.0, cells=24),
        timing=c.Timing(frame_count=frame_count, frame_dt=FRAME_DT, substep_dt=substep_dt),
        **{"material": JELLY, **parts},
    )


def make_rich_scene(folder: Path, body: Body, **parts: Any) -> CompiledScene:
    """A scene with one of everything that has numbers; ``parts`` in place of its own."""
    regions = tuple(
        c.MaterialRegion(point=(MIDDLE, MIDDLE, z), half_size=(1.0, 1.0, half), material=material)
        for z, half, material in ((1.75, 0.2, SAND), (1.45, 0.1, METAL))
    )
    everything = dict(
        material_regions=regions,
        forces=TERMS,
        constraints=IMPOSED,
        boundaries=BOUNDARIES,
        force_field=FIELD,
        gravity=(0.5, 0.0, -9.0),
        transfer=c.Transfer(damping_rate=0.4),
    )
    return compile_scene(make_config(folder, **{**everything, **parts}), body, folder)
