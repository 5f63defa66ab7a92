"""Base colours of glTF primitives: materials, textures, colours of vertices."""

from __future__ import annotations

from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.scene.mesh_formats.base import Neighbours
from physagent_jax.scene.mesh_formats.gltf_document import Document, read_uri
from physagent_jax.scene.mesh_formats.look import Look, Texture, Wrap, as_rgba, read_pixels

BLEND_CUTOFF = 0.02  # alpha below which a blended point cannot be seen
_WRAPS: dict[int, Wrap] = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"  # the older model, with a diffuse colour of its own


class Materials:
    """Looks of a document's primitives; each picture is decoded once.

    Args:
        document: The file.
        beside: Files that its pictures may name.
    """

    def __init__(self, document: Document, beside: Neighbours):
        self._document, self._tree, self._beside = document, document.tree, beside
        self._pictures: dict[int, np.ndarray | None] = {}

    def make_look(self, primitive: Any) -> Look | None:
        """The declared colours of a primitive; None = it has neither material nor colours of vertices."""
        attributes = primitive["attributes"]
        colours = None
        if "COLOR_0" in attributes:
            colours = as_rgba(self._document.read_accessor(attributes["COLOR_0"], normalise=True))
        if "material" not in primitive:
            return None if colours is None else Look(vertex_colours=colours, linear=True)
        material = self._tree["materials"][primitive["material"]]
        factor, info = _find_base_colour(material)
        texture = None if info is None else self._read_texture(info, attributes)
        cutoffs = {"MASK": float(material.get("alphaCutoff", 0.5)), "BLEND": BLEND_CUTOFF}
        mode = material.get("alphaMode", "OPAQUE")
        factor = np.clip(np.asarray(factor, np.float64).reshape(4), 0, 1)
        return Look(
            factor, colours, None, texture, linear=True, cutoff=cutoffs.get(mode), blended=mode == "BLEND"
        )

    def _read_texture(self, info: Any, attributes: Any) -> Texture | None:
        """A texture where its coordinates put it; None = it cannot be had, which is noted."""
        transform = info.get("extensions", {}).get("KHR_texture_transform", {})
        name = f"TEXCOORD_{transform.get('texCoord', info.get('texCoord', 0))}"
        texture = self._tree["textures"][info["index"]]
        if name not in attributes:
            self._beside.missing.append(f"a texture goes by {name}, which its faces do not have")
            return None
        pixels = self._read_picture(_find_source(texture))
        if pixels is None:
            return None
        uv = np.asarray(self._document.read_accessor(attributes[name], normalise=True), np.float64)[:, :2]
        sampler = self._tree["samplers"][texture["sampler"]] if "sampler" in texture else {}
        wrap = _read_wrap(sampler.get("wrapS")), _read_wrap(sampler.get("wrapT"))
        return Texture(pixels, _transform(uv, transform), wrap)

    def _read_picture(self, source: int | None) -> np.ndarray | None:
        if source is None:
            self._beside.missing.append("a texture is in a format that is not read, such as KTX2")
            return None
        if source not in self._pictures:
            self._pictures[source] = None
            image = self._tree["images"][source]
            try:
                if "bufferView" in image:
                    data = self._document.get_view(image["bufferView"])
                else:
                    data = read_uri(image["uri"], self._beside)
                self._pictures[source] = read_pixels(data)
            except (FileNotFoundError, UserError) as error:
                self._beside.missing.append(str(error))
        return self._pictures[source]


def _find_base_colour(material: Any) -> tuple[Any, Any]:
    """Factor and texture (None = none) of a material's base colour."""
    rough = material.get("pbrMetallicRoughness", {})
    gloss = material.get("extensions", {}).get(_GLOSSINESS)
    if gloss is not None and not rough.keys() & {"baseColorFactor", "baseColorTexture"}:
        return gloss.get("diffuseFactor", [1, 1, 1, 1]), gloss.get("diffuseTexture")
    return rough.get("baseColorFactor", [1, 1, 1, 1]), rough.get("baseColorTexture")


def _find_source(texture: Any) -> int | None:
    """Index of a texture's picture; None = only one that cannot be decoded."""
    webp = texture.get("extensions", {}).get("EXT_texture_webp", {})
    return webp.get("source", texture.get("source"))


def _read_wrap(code: int | None) -> Wrap:
    if code is None or code not in _WRAPS:
        return "repeat"
    return _WRAPS[code]


def _transform(uv: np.ndarray, transform: Any) -> np.ndarray:
    """Texture coordinates scaled, turned and shifted, as KHR_texture_transform defines it."""
    scale = np.asarray(transform.get("scale", [1, 1]), np.float64).reshape(2)
    offset = np.asarray(transform.get("offset", [0, 0]), np.float64).reshape(2)
    angle = float(transform.get("rotation", 0.0))
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return (uv * scale) @ turn.T + offset
