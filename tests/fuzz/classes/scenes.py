"""Scene files: every field at its edges, parsed and compiled on a tiny object."""

from __future__ import annotations

import functools
import json
import os
import tempfile
import warnings
from pathlib import Path

import numpy as np

from physagent_jax.kernels import use_cpu
from physagent_jax.mpm import kernels
from physagent_jax.mpm.checks import check_start
from physagent_jax.scene.body import Body, make_scene_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.config import SceneConfig, load_scene
from physagent_jax.scene.cost import Limits, check_cost, estimate_cost
from tests.fuzz import seeds
from tests.fuzz.contract import Case
from tests.fuzz.drawing import RAW, TEXTS, Draw, altered, at, damaged, encoded, of_schema, places

SCENE, SOLID, MASK = "scene.json", "solid.stl", "mask.npy"
CENTRE, HALF = [1.0, 1.0, 1.0], [0.6, 0.6, 0.6]
MATERIALS = [
    {"model": "neo_hookean"}, {"model": "fixed_corotated", "viscosity": 1.0}, {"model": "hencky", "damping_ratio": 0.1},
    {"model": "von_mises", "yield_stress": 2e3, "hardening_modulus": 10.0},
    {"model": "plasticine", "yield_stress": 2e3, "softening_modulus": 10.0},
    {"model": "drucker_prager", "friction_angle": 35.0, "cohesion": 10.0},
    {"model": "viscoplastic", "yield_stress": 1e3, "plastic_viscosity": 5.0},
    {"model": "snow", "hardening_coefficient": 8.0},
    {"model": "fluid", "bulk_modulus": 1e4, "tension": True}, {"model": "rigid"}, {"model": "stationary"},
]  # fmt: skip
BOUNDARIES = [
    {"kind": "domain_box", "padding": 3},
    {
        "kind": "half_space", "point": [1, 1, 0.4], "normal": [0, 0, 1], "friction": 0.3,
        "surface": "separate",
    },
    {
        "kind": "sphere", "point": [1, 1, 0.2], "radius": 0.2, "velocity": [0, 0.1, 0], "start": 0.0,
        "end": 1.0,
    },
    {
        "kind": "box", "point": [1, 1, 1], "half_size": [0.9, 0.9, 0.9], "container": True,
        "surface": "sticky",
    },
    {
        "kind": "mesh", "path": SOLID, "scale": 0.3, "position": [1, 1, 0.2], "rotation_degrees": [30],
        "rotation_axes": [2],
    },
    {
        "kind": "cuboid", "point": [1, 1, 0.2], "half_size": [0.1, 0.1, 0.1], "velocity": [0, 0, 0.5],
        "start": 0, "end": 1,
    },
]  # fmt: skip
CONSTRAINTS = [
    {
        "kind": "particle_translation", "point": CENTRE, "half_size": HALF, "velocity": [0, 0, 0.1],
        "end": 0.1,
    },
    {
        "kind": "particle_rotation", "point": CENTRE, "normal": [0, 0, 1], "half_height": 0.6,
        "radius": 0.6, "angular_velocity": 1.0, "axial_velocity": 0.1, "start": 0.01, "end": 0.05,
    },
    {
        "kind": "particle_impulse", "point": CENTRE, "half_size": HALF, "delta_velocity": [1, 0, 0],
        "start": 0.0, "duration": 0.01,
    },
    {"kind": "particle_impulse", "point": CENTRE, "half_size": HALF, "force": [1, 0, 0], "duration": 0.01},
    {
        "kind": "particle_release", "normal": [0, 0, 1], "start_position": 0.5, "end_position": 1.0,
        "layers": 4, "end": 0.08,
    },
]  # fmt: skip
REGIONS = [
    None,
    {"kind": "box", "low": [0, 0, 0], "high": [1, 1, 0.5]},
    {"kind": "half_space", "point": [0.5, 0.5, 0.5], "normal": [0, 0, 1]},
    {"kind": "sphere", "center": [0.5, 0.5, 0.5], "radius": 0.4},
]
ENVELOPES = [
    {"kind": "constant", "start": 0.0, "end": 0.1},
    {"kind": "ramp", "rise": 0.01, "fall": 0.01, "end": 0.08}, {"kind": "pulse", "start": 0.0, "end": 0.05},
    {"kind": "sine", "frequency": 2.0, "phase": 0.5},
]  # fmt: skip
FORCES = [
    {
        "kind": "wind", "direction": [1, 0, 0], "speed": 3.0, "linear_drag": 1.0, "quadratic_drag": 0.1,
        "center": CENTRE, "radius": 0.5,
    },
    {"kind": "attractor", "point": CENTRE, "strength": 1.0, "power": 2.0, "softening": 0.1},
    {
        "kind": "vortex", "point": CENTRE, "axis": [0, 0, 1], "swirl": 1.0, "inward": 0.1, "axial": 0.1,
        "core": 0.2, "power": 1.0,
    },
    {"kind": "turbulence", "strength": 1.0, "length_scale": 0.3, "time_scale": 0.2, "seed": 3, "modes": 8},
    {"kind": "uniform", "acceleration": [0, 1, 0]},
]  # fmt: skip
ACTIONS = [
    {"action_type": kind, "vector": [0.0, 0.6, 0.8], "magnitude": 1.0, "active_time": [0, 2], "region": None}
    for kind in ("translation", "scale", "impulse", "torque")
]
HELD = [
    {
        "constraint_type": "enforce_particle_translation",
        "vector": [0, 0, 1],
        "magnitude": 0.5,
        "active_time": [0, 2],
    },
    {"constraint_type": "particle_impulse", "vector": [1, 0, 0], "magnitude": -0.5, "active_time": [0, 1]},
]
ANCHORS = [
    {"kind": "none"}, {"kind": "base", "fraction": 0.2}, {"kind": "top"},
    {"kind": "box", "point": CENTRE, "half_size": HALF}, {"kind": "mask", "mask_path": MASK},
]  # fmt: skip


def make(draw: Draw) -> Case:
    """One scene file."""
    document = scene(draw)
    match draw.one(["altered"] * 6 + ["part", "part", "damaged", "schema", "schema", "reach"]):
        case "altered":
            what, content = altered(draw, document)
        case "part":
            what, content = _alter_part(draw, document)
        case "damaged":
            what, content = damaged(draw, encoded(document))
        case "reach":
            what, content = _redirect_path(draw, document)
        case _:
            drawn = of_schema(draw, _make_schema())
            keep = draw.sample(sorted(drawn), min(len(drawn), draw.one([1, 1, 2, 3])))
            document |= {key: drawn[key] for key in keep if key != "source"}
            what, content = f"{', '.join(keep)} of the schema", encoded(document)
    return Case(what, compiled, {SCENE: content, **files()})


@functools.cache
def files() -> dict[str, bytes]:
    """The files that scenes refer to."""
    mask = np.arange(60) % 2 == 0
    return {
        seeds.OBJECT: seeds.gaussians(),
        SOLID: seeds.meshes()["ball.stl"],
        MASK: seeds.npy(mask),
    }


def warm_up() -> None:
    """The kernels, and the first scene."""
    if use_cpu():
        kernels.load_cpu_kernels()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(action="ignore"):
        for name, content in {SCENE: encoded(usual_scene()), **files()}.items():
            Path(folder, name).write_bytes(content)
        compiled(Path(folder))


def usual_scene() -> dict:
    """A scene without anything special."""
    document = scene(Draw("the usual scene"))
    plain = {"forces": [], "constraints": [], "material": {}, "material_regions": [], "anchor": {}}
    return document | plain | {"boundaries": [{"kind": "domain_box"}]}


def scene(draw: Draw) -> dict:
    """A valid scene with a choice of everything that a scene may have."""
    forces = [
        {**draw.one(FORCES), "envelope": draw.one(ENVELOPES), "region": draw.one(REGIONS)}
        for _ in range(draw.one([0, 1, 2]))
    ]
    actions = [{**draw.one(ACTIONS), "region": draw.one(REGIONS)} for _ in range(draw.one([0, 1, 2]))]
    document = {
        "source": {"path": seeds.OBJECT, "surface_samples": 40, "opacity_threshold": 0.02, "extent": 0.8,
                   "crop": None, "rotation_degrees": [], "rotation_axes": []},
        "filling": {"cells": 6, "max_particles": 90, "exclude_direction": 5, "density_threshold": 5.0, "seed": 0},
        "material": draw.one(MATERIALS),
        "material_regions": [{"point": [1, 1, 1.3], "half_size": [1, 1, 0.3], "material": draw.one(MATERIALS)}]
        if draw.chance(0.2) else [],
        "domain": {"size": 2.0, "cells": 16},
        "timing": {"frame_count": 4, "frame_dt": 0.04, "substep_dt": "auto", "safety": 0.9, "force_substep": False},
        "transfer": {"scheme": "apic", "stress_form": "mls", "rpic_damping": 0.1, "damping_rate": 0.5},
        "gravity": [0.0, 0.0, -9.8],
        "always_gravity": draw.chance(0.5),
        "boundaries": [BOUNDARIES[0], *(draw.one(BOUNDARIES) for _ in range(draw.one([0, 1, 1, 2])))],
        "constraints": [draw.one(CONSTRAINTS) for _ in range(draw.one([0, 1, 1]))],
        "anchor": draw.one(ANCHORS),
        "force_field": {"default_drop": draw.chance(0.5), "actions": actions,
                        "constraints": [draw.one(HELD)] if draw.chance(0.3) else []},
        "forces": forces,
        "camera": {"azimuth_degrees": 20.0, "elevation_degrees": 10.0, "distance": 4.0, "fov_degrees": 40.0},
        "rendering": {"width": 32, "height": 32, "background": [1.0, 1.0, 1.0]},
    }  # fmt: skip
    return json.loads(json.dumps(document))


@functools.cache
def _make_schema() -> dict:
    return SceneConfig.model_json_schema()


def _alter_part(draw: Draw, document: dict) -> tuple[str, bytes]:
    """All changes in one part, so that rarely drawn fields get their share."""
    part = draw.one(sorted(document))
    what, content = altered(draw, {part: document[part]})
    try:
        return what, encoded(document | json.loads(content))
    except (ValueError, RecursionError, TypeError):
        return what, content


def _redirect_path(draw: Draw, document: dict) -> tuple[str, bytes]:
    """Names of files that lead elsewhere, or nowhere."""
    paths = [p for p in places(document) if p and p[-1] in ("path", "mask_path")]
    path = draw.one(paths)
    new = draw.one(
        [*TEXTS, "/dev/zero", "/dev/null", "/dev/stdin", "/proc/self/mem", "missing.ply", SCENE, "x" * 70_000]
    )
    at(document, path[:-1])[path[-1]] = new
    return f"{'.'.join(map(str, path))} = {new[:40]!r}", encoded(document, RAW[:0])


def compiled(folder: Path):
    """The compiled scene of a file: model, state and camera, as the simulator would begin with them."""
    config = load_scene(folder / SCENE)
    body = _make_body(config, folder)
    check_cost(estimate_cost(config, body), Limits())
    scene = compile_scene(config, body, folder)
    timing = config.timing
    check_start(
        scene.model,
        scene.state,
        frame_dt=timing.frame_dt,
        substep_dt=None if timing.substep_dt == "auto" else timing.substep_dt,
        safety=timing.safety,
    )
    return config, scene.model, scene.state, scene.camera


def _make_body(config: SceneConfig, folder: Path) -> Body:
    if config.source.path != seeds.OBJECT:
        return make_scene_body(config, folder)
    key = config.model_copy(update=dict(source=config.source, filling=config.filling, domain=config.domain))
    return _make_usual_body(
        json.dumps([key.source.model_dump(), key.filling.model_dump(), key.domain.model_dump()])
    )


@functools.lru_cache(maxsize=8)
def _make_usual_body(parts: str) -> Body:
    source, filling, domain = json.loads(parts)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, seeds.OBJECT).write_bytes(seeds.gaussians())
        config = SceneConfig.model_validate({"source": source, "filling": filling, "domain": domain})
        return make_scene_body(config, os.fspath(folder))
