"""Draco, the usual compression of meshes in glTF, read by its published decoder.

Source: the extension KHR_draco_mesh_compression, https://github.com/KhronosGroup/glTF/tree/main/extensions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from physagent_jax.core.errors import MissingPackageError

EXTENSION = "KHR_draco_mesh_compression"


def decode_primitives(tree: Any, read_view: Callable[[int], bytes], place: str) -> dict[int, np.ndarray]:
    """Decode what the file holds compressed and in no other way.

    Args:
        tree: The JSON of the file.
        read_view: Gives the bytes of a view of a buffer.
        place: The file, for messages.

    Returns:
        Values of accessors by their index, shape (count, components) each.

    Raises:
        MissingPackageError: The decoder is not installed.
        ValueError: What is compressed is not what the file says.
    """
    accessors = tree.get("accessors", [])
    found: dict[int, np.ndarray] = {}
    for primitive in (each for mesh in tree.get("meshes", []) for each in mesh["primitives"]):
        packed = primitive.get("extensions", {}).get(EXTENSION)
        if packed is None or "bufferView" in accessors[primitive["attributes"]["POSITION"]]:
            continue
        faces, arrays = _decode(read_view(packed["bufferView"]), place)
        values = {primitive["attributes"][name]: arrays[key] for name, key in packed["attributes"].items()}
        values[primitive["indices"]] = faces.reshape(-1, 1)
        for index, array in values.items():
            count = accessors[index]["count"]
            if len(array) != count:
                raise ValueError(f"{len(array)} compressed values, but accessors[{index}] has {count}")
        found |= values
    return found


def _decode(data: bytes, place: str) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """Triangles, shape (m, 3), and attributes by their number, shape (n, components) each."""
    try:
        import DracoPy
    except ImportError:
        raise MissingPackageError(
            f"{place} is compressed with Draco: reading it needs DracoPy", extra="draco"
        ) from None
    try:
        mesh = DracoPy.decode(data)
    except (DracoPy.FileTypeException, ValueError) as error:
        raise ValueError(f"Draco: {error}") from None
    if not isinstance(mesh, DracoPy.DracoMesh):
        raise ValueError("Draco: no triangles")
    return np.asarray(mesh.faces), {each["unique_id"]: each["data"] for each in mesh.attributes}
