"""Mesh files that lie about what they hold, name files elsewhere, or are not what they seem: told, never believed."""

import base64
import json
import os
import struct

import numpy as np
import pytest
import trimesh

from physagent_jax.core.errors import UserError
from physagent_jax.scene.mesh_files import read_mesh

TETRAHEDRON = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
AREA = 1.5 + np.sqrt(3) / 2


def refused(path, *fragments):
    with pytest.raises(UserError) as error:
        read_mesh(path)
    message = str(error.value)
    assert "\n" not in message and len(message) < 600
    for fragment in fragments:
        assert fragment in message, message


def glb(edit=None, mesh=None):
    """A box or another mesh as GLB, its JSON changed by ``edit``."""
    data = (mesh or trimesh.creation.box()).export(file_type="glb")
    (length,) = struct.unpack("<I", data[12:16])
    tree, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    if edit is not None:
        edit(tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
    return head + struct.pack("<II", len(text), 0x4E4F534A) + text + rest


def put(*place, value):
    def edit(tree):
        *parents, last = place
        for key in parents:
            tree = tree[key]
        tree[last] = value

    return edit


FACE = b"\0" * 50
BROKEN = {
    "two numbers.obj": (b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n", "three numbers"),
    "one of two.obj": (TETRAHEDRON.replace(b"v 1 0 0", b"v 1 0"), "three numbers"),
    "nan.obj": (TETRAHEDRON.replace(b"v 1 0 0", b"v nan 0 0"), "three numbers"),
    "words.obj": (TETRAHEDRON.replace(b"v 1 0 0", b"v one 0 0"), "three numbers"),
    "beyond.obj": (TETRAHEDRON + b"f 1 2 99\n", "cannot read"),
    "before.obj": (TETRAHEDRON + b"f -1 -2 -9\n", "cannot read"),
    "zeroth.obj": (TETRAHEDRON + b"f 0 1 2\n", "counted from 1"),
    "far.obj": (TETRAHEDRON.replace(b"v 1 0 0", b"v 1e30 0 0"), "beyond"),
    "empty.obj": (b"", "no faces"),
    "empty.stl": (b"", "no STL"),
    "many.stl": (b"\0" * 80 + struct.pack("<I", 1000) + FACE, "1,000 faces"),
    "most.stl": (b"\0" * 80 + struct.pack("<I", 2**32 - 1) + FACE, "faces of 50 bytes"),
    "many.off": (b"OFF\n99999999999999 1 0\n0 0 0\n", "cannot read"),
    "beyond.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "cannot read"),
    "negative.off": (b"OFF\n-3 -1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "no faces"),
    "empty.glb": (b"", "no GLB"),
    "half.glb": (glb()[:400], "JSON"),
    "long json.glb": (glb()[:12] + struct.pack("<I", 2**31) + glb()[16:], "JSON"),
    "long chunk.glb": (glb()[:-240], "chunk"),
    "no accessors.glb": (glb(put("accessors", value=[])), "no valid glTF"),
    "no indices.glb": (glb(put("accessors", 0, "count", value=0)), "empty"),
    "no positions.glb": (glb(put("accessors", 1, "count", value=0)), "empty"),
    "many.glb": (glb(put("accessors", 0, "count", value=10**12)), "announces more"),
    "negative.glb": (glb(put("accessors", 0, "count", value=-5)), "no valid glTF"),
    "no view.glb": (glb(put("accessors", 0, value={"componentType": 5125, "type": "SCALAR", "count": 10**10})),
                    "announces more"),
    "long view.glb": (glb(put("bufferViews", 0, "byteLength", value=10**10)), "announces more"),
    "late view.glb": (glb(put("bufferViews", 0, "byteOffset", value=10**10)), "announces more"),
    "strides.glb": (glb(put("bufferViews", 1, "byteStride", value=10**6)), "announces more"),
    "component.glb": (glb(put("accessors", 0, "componentType", value=1)), "no valid glTF"),
    "mesh.glb": (glb(put("nodes", 0, "mesh", value=7)), "no valid glTF"),
    "two parents.glb": (glb(put("nodes", 0, "children", value=[0, 0])), "two parents"),
    "far.glb": (glb(put("nodes", 0, "scale", value=[1e300] * 3)), "beyond"),
    "cutoff.glb": (glb(lambda tree: (put("materials", value=[{"alphaMode": "MASK", "alphaCutoff": "x"}])(tree),
                                     put("meshes", 0, "primitives", 0, "material", value=0)(tree))), "no valid glTF"),
    "list.gltf": (b"[1, 2]", "no valid glTF"),
    "deep.gltf": (b"[" * 100_000, "nested too deeply"),
    "digits.gltf": (b'{"buffers": ' + b"9" * 5000 + b"}", "digits"),
    "kind.obk": (b"", "`.obj`"),
    "lists.ply": (b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nelement face 1\n"
                  b"property list uint int vertex_indices\nend_header\n\xff\xff\xff\xff", "announces more"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_a_file_that_does_not_hold_what_it_says_is_refused(name, tmp_path):
    content, fragment = BROKEN[name]
    (tmp_path / name).write_bytes(content)
    refused(tmp_path / name, fragment)


def test_many_places_of_one_mesh_are_counted_before_they_are_made(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=5)
    (tmp_path / "a.glb").write_bytes(glb(put("nodes", value=[{"mesh": 0}] * 6000), ball))
    refused(tmp_path / "a.glb", "61,452,000")


@pytest.mark.parametrize(
    "content",
    [
        b"# caf\xe9\no t\xeate\n" + TETRAHEDRON,
        TETRAHEDRON.replace(b"\n", b"\r\n"),
        TETRAHEDRON.replace(b"v 1 0 0", b"v 1. -0 .0e-3 0.5 0.5 0.5"),
        TETRAHEDRON.replace(b"f 1 3 2", b"f 1//1 3//1 2//1"),
        TETRAHEDRON.replace(b"f 1 3 2", b"f -4 -2 -3"),
        TETRAHEDRON.replace(b"f 1 3 2", b"f 01 03 02"),
        b"mtllib gone.mtl\nusemtl a\n" + TETRAHEDRON,
        TETRAHEDRON + b"\0\0",
        b"v 0 0 0\nv 1 0 0\nusemtl a\nf 1 2\nusemtl b\n"
        + TETRAHEDRON.replace(b"1 3 2", b"3 5 4")
        .replace(b"1 2 4", b"3 4 6")
        .replace(b"1 4 3", b"3 6 5")
        .replace(b"2 3 4", b"4 5 6"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*colours are left out")
def test_what_programs_write_in_obj_is_read(content, tmp_path):
    (tmp_path / "a.obj").write_bytes(content)
    assert read_mesh(tmp_path / "a.obj").area == pytest.approx(AREA)


def test_stl_is_text_or_binary_as_its_size_says(tmp_path):
    """A binary file may begin with `solid`, too."""
    ball = trimesh.creation.icosphere(subdivisions=1)
    binary = bytearray(ball.export(file_type="stl"))
    binary[:5] = b"solid"
    text = ball.export(file_type="stl_ascii").replace("solid", "solid caf\u00e9", 1).encode("latin-1")
    for content in (binary, text):
        (tmp_path / "a.stl").write_bytes(content)
        assert read_mesh(tmp_path / "a.stl").area == pytest.approx(ball.area, rel=1e-6)


@pytest.mark.parametrize(
    "name", ["/dev/urandom", "../secret.mtl", "pipe.mtl", "link.mtl", "x" * 5000, "a\udcff"]
)
def test_files_elsewhere_are_not_read_for_colours(name, tmp_path):
    """A device, the folder above, a pipe and a link out of the folder: the shape is read, with a warning."""
    folder = tmp_path / "meshes"
    folder.mkdir()
    (tmp_path / "secret.mtl").write_text("newmtl a\nKd 1 0 0\n")
    os.mkfifo(folder / "pipe.mtl")
    (folder / "link.mtl").symlink_to(tmp_path / "secret.mtl")
    line = b"mtllib " + os.fsencode(name) + b"\nusemtl a\n"
    (folder / "a.obj").write_bytes(line + TETRAHEDRON)
    with pytest.warns(UserWarning, match="colours are left out"):
        mesh = read_mesh(folder / "a.obj")
    assert mesh.area == pytest.approx(AREA)


def gltf(uri):
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    return positions, json.dumps(
        {
            "asset": {"version": "2.0"},
            "buffers": [{"uri": uri, "byteLength": 36}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
        }
    )


@pytest.mark.parametrize(
    "uri", ["gone.bin", "/dev/urandom", "../a.bin", "http://127.0.0.1:9/a.bin", "x" * 5000]
)
def test_buffers_must_lie_in_the_meshs_folder(uri, tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    positions, text = gltf(uri)
    (tmp_path / "a.bin").write_bytes(positions)
    (folder / "a.gltf").write_text(text)
    refused(folder / "a.gltf", "buffers[0]", "not in its folder")


def test_buffers_beside_and_inside_a_gltf_are_read(tmp_path):
    positions, text = gltf("a.bin")
    (tmp_path / "a.bin").write_bytes(positions)
    (tmp_path / "a.gltf").write_text(text)
    assert read_mesh(tmp_path / "a.gltf").area == pytest.approx(0.5)
    inline = "data:application/octet-stream;base64," + base64.b64encode(positions).decode()
    (tmp_path / "a.gltf").write_text(gltf(inline)[1])
    assert read_mesh(tmp_path / "a.gltf").area == pytest.approx(0.5)
    (tmp_path / "a.bin").write_bytes(positions[:-1])
    (tmp_path / "a.gltf").write_text(text)
    refused(tmp_path / "a.gltf", "announces more")
