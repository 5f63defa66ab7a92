"""Reading, checking and writing scene files."""

from __future__ import annotations

import json
from pathlib import Path

from physagent_jax.core.reading import parse_model, read_model
from physagent_jax.scene.config.scene import SceneConfig


def load_scene(path: str | Path) -> SceneConfig:
    """Read and validate a scene file.

    Raises:
        UserError: The file is missing, not JSON, or breaks the schema (the message names the field).
    """
    return read_model(path, SceneConfig, what="the scene file")


def parse_scene(data: object, *, origin: str = "scene") -> SceneConfig:
    """Validate decoded JSON as a scene; ``origin`` names it in messages."""
    return parse_model(data, SceneConfig, origin)


def dump_scene(config: SceneConfig) -> str:
    """Canonical JSON text: the same config gives the same bytes."""
    return json.dumps(config.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"
