"""Simulating one scene into a run folder."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from physagent_jax.output.splats import SplatFormat
from physagent_jax.run.artifacts import write_presentation, write_recording, write_splats
from physagent_jax.run.manifest import Stages
from physagent_jax.run.provenance import hash_settings, make_manifest
from physagent_jax.run.store import RunStore
from physagent_jax.scene.body import make_scene_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.config import SceneConfig
from physagent_jax.scene.cost import Limits, check_cost, estimate_cost
from physagent_jax.scene.load import hash_file
from physagent_jax.simulation.ahead import compile_ahead
from physagent_jax.simulation.ending import simulate_ending
from physagent_jax.simulation.record import SimulationRecord
from physagent_jax.simulation.simulate import Progress, simulate_scene
from physagent_jax.simulation.stopwatch import Stopwatch


def replay_scene(
    config: SceneConfig,
    scene_file: Path,
    out: Path,
    progress: Progress,
    *,
    command: str,
    save_frames: bool,
    save_splats: SplatFormat | Literal[False],
    video_size: tuple[int, int] | None,
    limits: Limits,
    overwrite: bool,
    warn: Callable[[str], None],
) -> tuple[SimulationRecord, Stages]:
    """Simulate ``config``, read from ``scene_file``; write scene.json, simulation.json, videos and motion to ``out``.

    A folder that holds this very result already is left as it is, unless ``overwrite`` is set.

    Raises:
        UserError: The scene cannot be simulated, or ``out`` cannot be written or holds something else.
    """
    base_dir = scene_file.parent
    files = config.files(base_dir)
    settings = config.model_dump(mode="json", exclude={"source": {"path"}})
    inputs = {name: hash_file(path) for name, path in files.items()}
    inputs["settings"] = hash_settings((settings, save_frames, save_splats, video_size))
    manifest = make_manifest(command=command, prompt=config.prompt, seed=config.filling.seed, inputs=inputs)
    with RunStore.open(out, manifest, overwrite=overwrite, needed=[scene_file, *files.values()]) as store:
        record = store.read("simulation.json", SimulationRecord)
        if store.manifest.complete and record is not None:
            return record, store.manifest.stages
        compile_ahead()
        watch = Stopwatch()
        with watch("prepare"), warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", UserWarning)
            body = make_scene_body(config, base_dir)
            check_cost(estimate_cost(config, body, video_size), limits)
            scene = compile_scene(config, body, base_dir)
        for warning in caught:
            warn(str(warning.message))
        recording = simulate_scene(scene, watch=watch, progress=progress)
        store.begin()
        with watch("write"):
            write_recording(store, scene, recording, save_frames=save_frames)
            x, F = recording.x[:, scene.back], recording.F[:, scene.back]
            if video_size is not None:
                write_presentation(store, config, body, *simulate_ending(recording), video_size)
            if save_splats:
                write_splats(store, config, body, x, F, save_splats)
        stages = Stages(**watch.seconds())
        store.finish(stages=stages, warnings=tuple(str(each.message) for each in caught))
    return recording.record, stages
