"""Scene files: our own, or PhysGaussian's."""

from __future__ import annotations

import warnings
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import read_json
from physagent_jax.scene.config import SceneConfig, SplatEncoding, parse_scene
from physagent_jax.scene.load import check_object, load_object
from physagent_jax.scene.physgaussian import import_physgaussian, is_physgaussian
from physagent_jax.scene.placement import place


def read_scene(
    path: Path, object_path: Path | None = None, splat_encoding: SplatEncoding | None = None
) -> tuple[SceneConfig, list[str]]:
    """A scene file in either format, and warnings about what was not understood.

    Args:
        path: The file.
        object_path: The object's file, where the scene does not name it or it has moved; None = as the scene says.
        splat_encoding: How the object's scales and opacities are stored; None = as the scene says.

    Raises:
        UserError: The file is not a scene, or the object it needs is not given.
    """
    if object_path is not None:
        check_object(object_path)
    data = read_json(path, what="the scene file")
    if not isinstance(data, dict) or not is_physgaussian(data):
        scene = parse_scene(data, origin=str(path))
        changed: dict = {} if object_path is None else dict(path=str(object_path.resolve()))
        changed |= {} if splat_encoding is None else dict(splat_encoding=splat_encoding)
        return _change_source(scene, changed), []
    if object_path is None:
        raise UserError(f"{path} is a PhysGaussian config, which names no object", do="Pass --object x.ply")
    return _import(data, object_path, dict(splat_encoding=splat_encoding))


def _change_source(scene: SceneConfig, changed: dict) -> SceneConfig:
    return scene.model_copy(update=dict(source=scene.source.model_copy(update=changed)))


def _import(data: dict, object_path: Path, changed: dict) -> tuple[SceneConfig, list[str]]:
    """Import twice: the camera's radius is in file units, whose size is known once the object is placed."""
    path = str(object_path.resolve())
    scene = _change_source(import_physgaussian(data, object_path=path, file_units_per_metre=1.0)[0], changed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the same warnings come when the scene's body is made
        loaded = load_object(scene.source, ".")
        _, placement = place(loaded.cloud, scene.source, scene.domain, loaded.origin)
    scene, notes = import_physgaussian(data, object_path=path, file_units_per_metre=1 / placement.scale)
    return _change_source(scene, changed), notes
