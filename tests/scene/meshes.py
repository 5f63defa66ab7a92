"""glTF files built by hand from the specification, byte by byte: no library of ours or of others writes them."""

import base64
import io
import json
import struct

import numpy as np
from PIL import Image

QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
QUAD_FACES = np.array([0, 1, 2, 0, 2, 3], np.uint16)
QUAD_UV = np.array(
    [[0, 1], [1, 1], [1, 0], [0, 0]], np.float32
)  # V runs downwards: the picture stands upright
_CODES = {"float32": 5126, "uint8": 5121, "uint16": 5123, "int16": 5122, "int8": 5120}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class GltfBuilder:
    """Collects buffers, accessors, materials and primitives."""

    def __init__(self):
        self.binary = b""
        self.tree = {
            "asset": {"version": "2.0"},
            "bufferViews": [],
            "accessors": [],
            "materials": [],
            "images": [],
        }
        self.tree |= {"textures": [], "samplers": [], "meshes": [], "nodes": []}

    def add_view(self, data: bytes) -> int:
        self.tree["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        )
        self.binary += data + b"\0" * (-len(data) % 4)
        return len(self.tree["bufferViews"]) - 1

    def add_accessor(self, values: np.ndarray, normalized: bool = False) -> int:
        width = 1 if values.ndim == 1 else values.shape[1]
        self.tree["accessors"].append(
            {
                "bufferView": self.add_view(values.tobytes()),
                "componentType": _CODES[values.dtype.name],
                "count": len(values),
                "type": _SHAPES[width],
                "normalized": normalized,
            }
        )
        return len(self.tree["accessors"]) - 1

    def add_texture(self, pixels: np.ndarray, **sampler) -> int:
        self.tree["images"].append({"bufferView": self.add_view(png(pixels)), "mimeType": "image/png"})
        self.tree["samplers"].append(sampler)
        last = len(self.tree["images"]) - 1
        self.tree["textures"].append({"source": last, "sampler": last})
        return last

    def add_material(self, factor=None, texture=None, **rest) -> int:
        base = {} if factor is None else {"baseColorFactor": list(factor)}
        if texture is not None:
            base["baseColorTexture"] = texture if isinstance(texture, dict) else {"index": texture}
        self.tree["materials"].append({"pbrMetallicRoughness": base, **rest})
        return len(self.tree["materials"]) - 1

    def add_primitive(self, positions=QUAD, faces=QUAD_FACES, material=None, mode=None, **attributes) -> dict:
        part = {"attributes": {"POSITION": self.add_accessor(positions)}}
        for name, values in attributes.items():
            part["attributes"][name] = self.add_accessor(values, values.dtype.kind in "iu")
        if faces is not None:
            part["indices"] = self.add_accessor(faces)
        if material is not None:
            part["material"] = material
        if mode is not None:
            part["mode"] = mode
        return part

    def add_node(self, *primitives, **node) -> int:
        self.tree["meshes"].append({"primitives": list(primitives)})
        self.tree["nodes"].append({"mesh": len(self.tree["meshes"]) - 1, **node})
        return len(self.tree["nodes"]) - 1

    def glb(self) -> bytes:
        tree = {key: value for key, value in self.tree.items() if value}
        tree |= {"buffers": [{"byteLength": len(self.binary)}]}
        tree.setdefault("scenes", [{"nodes": list(range(len(self.tree["nodes"])))}])
        text = json.dumps(tree).encode()
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self.binary)
        head = struct.pack("<4sIIII", b"glTF", 2, size, len(text), 0x4E4F534A)
        return head + text + struct.pack("<II", len(self.binary), 0x004E4942) + self.binary

    def gltf(self) -> bytes:
        tree = {key: value for key, value in self.tree.items() if value}
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
        tree |= {"buffers": [{"byteLength": len(self.binary), "uri": uri}]}
        return json.dumps(tree | {"scenes": [{"nodes": list(range(len(self.tree["nodes"])))}]}).encode()


def png(pixels: np.ndarray) -> bytes:
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "png")
    return out.getvalue()


def one_quad(material=None, **attributes) -> bytes:
    """A unit square, in a builder that ``material`` is called with."""
    builder = GltfBuilder()
    index = material(builder) if material else None
    builder.add_node(builder.add_primitive(material=index, **attributes))
    return builder.glb()
