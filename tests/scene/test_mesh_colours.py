"""Colours that mesh files declare arrive as they are declared: files by hand, answers from the specifications."""

import json
import struct
import sys

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.covariance import quats_scales_to_covariances
from physagent_jax.render import look_at, render
from physagent_jax.scene.mesh import GRAIN, TONE, gaussians_from_mesh, sample_mesh
from physagent_jax.scene.mesh_files import read_mesh, read_named_parts, read_parts
from physagent_jax.scene.mesh_formats import FORMATS, find_mesh_format
from physagent_jax.scene.mesh_formats.look import as_rgba, decode_srgb, encode_srgb
from physagent_jax.scene.surfels import SH_DC, bake_light
from tests.scene.meshes import QUAD, QUAD_FACES, QUAD_UV, GltfBuilder, one_quad, png

LIGHT = float(bake_light(np.array([[0.0, 0.0, 1.0]]))[0])  # on the squares, which face upwards
RED, GREEN, BLUE, GREY = [200, 20, 10], [10, 180, 30], [20, 30, 190], [90, 90, 90]


def sampled(path, count=300):
    """Positions and unlit colours, without perception's grain, of the Gaussians of a file of squares that face +z."""
    cloud = sample_mesh(path, count=count, smooth=False)[1]
    return np.asarray(cloud.means, float), (np.asarray(cloud.sh)[:, 0] * SH_DC + 0.5) / LIGHT


def same(rgb, expected, atol=2e-6):
    """Lit from above, full white is a little beyond what a picture can hold."""
    np.testing.assert_allclose(rgb, np.minimum(np.broadcast_to(expected, rgb.shape), 1 / LIGHT), atol=atol)


def write(folder, name, content):
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder / name


def image(*rows):
    return np.array(rows, np.uint8)


# --- glTF ---------------------------------------------------------------------------------------------------


def test_srgb_is_that_of_the_standard():
    """IEC 61966-2-1: half of the light is 188 of 255, and both pieces meet."""
    assert round(255 * float(encode_srgb(np.array(0.5)))) == 188
    np.testing.assert_allclose(encode_srgb(np.array([0, 0.0031308, 1])), [0, 0.04045, 1], atol=1e-5)
    values = np.linspace(0, 1, 101)
    np.testing.assert_allclose(encode_srgb(decode_srgb(values)), values, atol=1e-12)


def test_a_texture_lies_where_its_coordinates_put_it(tmp_path):
    pixels = image([RED, GREEN], [BLUE, GREY])  # the first row is on top
    path = write(
        tmp_path,
        "a.glb",
        one_quad(lambda b: b.add_material(texture=b.add_texture(pixels)), TEXCOORD_0=QUAD_UV),
    )
    x, rgb = sampled(path)
    expected = pixels[(x[:, 1] < 0.5).astype(int), (x[:, 0] > 0.5).astype(int)] / 255
    np.testing.assert_allclose(rgb, expected, atol=2e-6)


@pytest.mark.parametrize("uv", ["uint8", "uint16"])
def test_texture_coordinates_may_be_integers(uv, tmp_path):
    pixels = image([RED, GREEN], [BLUE, GREY])
    whole = (QUAD_UV * np.iinfo(uv).max).astype(uv)
    path = write(
        tmp_path, "a.glb", one_quad(lambda b: b.add_material(texture=b.add_texture(pixels)), TEXCOORD_0=whole)
    )
    x, rgb = sampled(path)
    expected = pixels[(x[:, 1] < 0.5).astype(int), (x[:, 0] > 0.5).astype(int)] / 255
    np.testing.assert_allclose(rgb, expected, atol=2e-6)


@pytest.mark.parametrize(
    ("mode", "order"),
    [(10497, [0, 1, 0, 1]), (33648, [0, 1, 1, 0]), (33071, [0, 1, 1, 1]), (None, [0, 1, 0, 1])],
)
def test_textures_repeat_mirror_or_are_clamped(mode, order, tmp_path):
    """U from 0 to 2 across the square: four texels, in the order of the sampler's rule."""
    sampler = {} if mode is None else {"wrapS": mode, "wrapT": mode}
    make = lambda b: b.add_material(texture=b.add_texture(image([RED, GREEN]), **sampler))  # noqa: E731
    path = write(tmp_path, "a.glb", one_quad(make, TEXCOORD_0=QUAD_UV * np.float32([2, 1])))
    x, rgb = sampled(path)
    expected = np.array([RED, GREEN])[np.array(order)[(4 * x[:, 0]).astype(int)]] / 255
    np.testing.assert_allclose(rgb, expected, atol=2e-6)


def test_a_texture_transform_scales_turns_and_shifts_and_names_its_own_coordinates(tmp_path):
    """KHR_texture_transform: (u, v) -> (cos u + sin v, cos v - sin u) after the scale, before the offset."""
    pixels = np.random.default_rng(0).integers(0, 255, (4, 4, 3), np.uint8)
    transform = {"scale": [2, 1], "rotation": np.pi / 2, "offset": [0.25, 2.0], "texCoord": 1}
    info = lambda i: {"index": i, "extensions": {"KHR_texture_transform": transform}}  # noqa: E731
    make = lambda b: b.add_material(texture=info(b.add_texture(pixels)))  # noqa: E731
    path = write(tmp_path, "a.glb", one_quad(make, TEXCOORD_0=0 * QUAD_UV, TEXCOORD_1=QUAD_UV))
    x, rgb = sampled(path)
    u, v = 2 * x[:, 0], 1 - x[:, 1]
    column, row = (np.floor(4 * (each % 1)).astype(int) for each in (v + 0.25, 2 - u))
    clear = (np.abs(4 * u - np.round(4 * u)) > 1e-3) & (np.abs(4 * v - np.round(4 * v)) > 1e-3)
    np.testing.assert_allclose(rgb[clear], pixels[row, column][clear] / 255, atol=2e-6)


def test_a_factor_is_linear_light_and_one_colour_is_a_colour(tmp_path):
    path = write(tmp_path, "a.glb", one_quad(lambda b: b.add_material(factor=(0.5, 0.2, 0.0, 1))))
    np.testing.assert_allclose(sampled(path)[1] * 255, [[188, 124, 0]] * 300, atol=0.5)


def test_a_texture_of_one_grey_is_that_grey(tmp_path):
    make = lambda b: b.add_material(texture=b.add_texture(image([GREY])))  # noqa: E731
    path = write(tmp_path, "a.glb", one_quad(make, TEXCOORD_0=QUAD_UV))
    np.testing.assert_allclose(sampled(path)[1], 90 / 255, atol=2e-6)


@pytest.mark.parametrize("dtype", ["float32", "uint8", "uint16"])
@pytest.mark.parametrize("width", [3, 4])
def test_colours_of_vertices_are_linear_whatever_their_type(dtype, width, tmp_path):
    values = np.array([[1, 0.5, 0, 1], [0, 0.5, 0.2, 1], [0, 0.5, 1, 1], [1, 0.5, 0.2, 1]])[:, :width]
    stored = (
        values.astype(dtype) if dtype == "float32" else np.round(values * np.iinfo(dtype).max).astype(dtype)
    )
    path = write(tmp_path, "a.glb", one_quad(COLOR_0=stored))
    x, rgb = sampled(path)
    np.testing.assert_allclose(rgb[:, 0], encode_srgb(1 - x[:, 0]), atol=0.02)  # 1 at x = 0 and 0 at x = 1
    np.testing.assert_allclose(rgb[:, 1] * 255, 188, atol=0.6)


def test_factor_texture_and_vertex_colours_are_multiplied_in_linear_light(tmp_path):
    make = lambda b: b.add_material((0.5, 1, 0.25, 1), b.add_texture(image([[188, 255, 255]])))  # noqa: E731
    half = np.full((4, 4), 128, np.uint8)
    path = write(tmp_path, "a.glb", one_quad(make, TEXCOORD_0=QUAD_UV, COLOR_0=half))
    linear = np.array([0.5 * decode_srgb(188 / 255), 1, 0.25]) * 128 / 255
    np.testing.assert_allclose(sampled(path)[1], [encode_srgb(linear)] * 300, atol=2e-6)


def test_every_primitive_of_every_node_keeps_its_own_material(tmp_path):
    """A house: walls with one texture, a roof with another, a door with a factor, a bare step; and a copy of all."""
    builder = GltfBuilder()
    up = np.float32([0, 0, 1])
    skins = [
        builder.add_material(texture=builder.add_texture(image([RED]))),
        builder.add_material(texture=builder.add_texture(image([GREEN]))),
        builder.add_material(factor=(0, 0, 0.5, 1)),
        None,
    ]
    parts = [
        builder.add_primitive(QUAD + k * up, material=skin, TEXCOORD_0=QUAD_UV)
        for k, skin in enumerate(skins)
    ]
    builder.add_node(*parts)
    builder.tree["nodes"].append({"mesh": 0, "translation": [10, 0, 0], "scale": [2, 2, 1]})
    x, rgb = sampled(write(tmp_path, "house.glb", builder.glb()), 2000)
    expected = np.array([RED, GREEN, [0, 0, 188], 255 * np.array(TONE)]) / 255
    layer = np.round(x[:, 2]).astype(int)
    assert set(layer[x[:, 0] > 5]) == set(layer[x[:, 0] < 5]) == {0, 1, 2, 3}
    assert np.abs(rgb - expected[layer])[layer < 3].max() < 0.002
    assert np.abs(rgb / TONE - 1)[layer == 3].max() <= GRAIN + 1e-6


@pytest.mark.parametrize(
    ("mode", "kept"),
    [
        ({}, 1.0),
        ({"alphaMode": "BLEND"}, 0.75),
        ({"alphaMode": "MASK"}, 0.5),
        ({"alphaMode": "MASK", "alphaCutoff": 0.9}, 0.25),
    ],
)
def test_transparent_texels_have_no_gaussians(mode, kept, tmp_path):
    pixels = image([[*RED, 255], [*RED, 180], [*RED, 100], [*RED, 0]])
    make = lambda b: b.add_material(texture=b.add_texture(pixels), **mode)  # noqa: E731
    path = write(tmp_path, "a.glb", one_quad(make, TEXCOORD_0=QUAD_UV))
    cloud = gaussians_from_mesh(path, count=400)
    assert cloud.count == 400
    x = np.asarray(cloud.means)
    assert x[:, 0].max() == pytest.approx(kept, abs=0.02)
    # As many on less area: the discs are smaller.
    assert float(cloud.scales[0, 0]) == pytest.approx(0.7 * np.sqrt(kept / 400), rel=0.05)


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.5, 0.8, 0.97])
@pytest.mark.parametrize("mode", ["OPAQUE", "MASK", "BLEND"])
def test_a_pane_stops_the_share_of_light_that_its_file_says(mode, alpha, tmp_path):
    make = lambda b: b.add_material(factor=(0.2, 0.2, 0.2, alpha), alphaMode=mode, alphaCutoff=0.05)  # noqa: E731
    cloud = gaussians_from_mesh(write(tmp_path, "a.glb", one_quad(make)), count=1500)
    splats = Splats(
        cloud.means,
        quats_scales_to_covariances(cloud.quats, cloud.scales),
        cloud.opacities,
        cloud.sh,
        jnp.tile(jnp.eye(3), (cloud.count, 1, 1)),
    )
    camera = look_at((0.5, 0.5, 3), (0.5, 0.5, 0), (0, 1, 0), fov_degrees=14, width=160, height=160)
    covered = np.asarray(render(splats, camera).alpha)
    assert covered.mean() == pytest.approx(alpha if mode == "BLEND" else 0.99, abs=0.02)
    assert covered.std() < 0.1


def test_what_is_transparent_all_over_is_refused(tmp_path):
    make = lambda b: b.add_material(factor=(1, 1, 1, 0), alphaMode="BLEND")  # noqa: E731
    with pytest.raises(UserError, match="transparent all over"):
        gaussians_from_mesh(write(tmp_path, "a.glb", one_quad(make)), count=50)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda tree: tree["images"].__setitem__(0, {"uri": "gone.png"}), "gone.png"),
        (
            lambda tree: tree["textures"].__setitem__(
                0, {"extensions": {"KHR_texture_basisu": {"source": 0}}}
            ),
            "KTX2",
        ),
        (lambda tree: tree["images"][0].__setitem__("bufferView", 0), "decoded"),
        (lambda tree: tree["meshes"][0]["primitives"][0]["attributes"].pop("TEXCOORD_0"), "TEXCOORD_0"),
    ],
)
def test_a_texture_that_cannot_be_had_is_said_and_the_factor_stays(spoil, reason, tmp_path):
    builder = GltfBuilder()
    skin = builder.add_material((0.5, 0, 0, 1))
    part = builder.add_primitive(material=skin, TEXCOORD_0=QUAD_UV)
    builder.tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
        "index": builder.add_texture(image([GREEN]))
    }
    builder.add_node(part)
    spoil(builder.tree)
    with pytest.warns(UserWarning, match=f"colours are left out: .*{reason}"):
        rgb = sampled(write(tmp_path, "a.glb", builder.glb()))[1]
    np.testing.assert_allclose(rgb * 255, [[188, 0, 0]] * 300, atol=0.6)


def test_the_older_model_of_glossy_materials_has_its_diffuse_colour(tmp_path):
    gloss = {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0, 0.5, 0, 1]}}
    path = write(tmp_path, "a.glb", one_quad(lambda b: b.add_material(extensions=gloss)))
    np.testing.assert_allclose(sampled(path)[1] * 255, [[0, 188, 0]] * 300, atol=0.6)


# --- glTF: shapes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("mode", "faces"), [(5, [0, 1, 3, 2]), (6, [0, 1, 2, 3]), (4, [0, 1, 2, 0, 2, 3])])
def test_strips_and_fans_are_triangles(mode, faces, tmp_path):
    builder = GltfBuilder()
    builder.add_node(builder.add_primitive(faces=np.array(faces, np.uint8), mode=mode))
    mesh = read_mesh(write(tmp_path, "a.glb", builder.glb()))
    assert mesh.area == pytest.approx(1.0)
    np.testing.assert_allclose(mesh.face_normals, [[0, 0, 1]] * 2, atol=1e-12)


def test_nodes_turn_scale_mirror_and_move_and_positions_may_be_integers(tmp_path):
    builder = GltfBuilder()
    small = (QUAD * np.iinfo(np.int16).max).astype(np.int16)  # KHR_mesh_quantization
    part = builder.add_primitive(small)
    builder.tree["accessors"][part["attributes"]["POSITION"]]["normalized"] = True
    child = builder.add_node(part, scale=[2, -3, 1])
    half = float(np.sqrt(0.5))
    builder.tree["nodes"].append(
        {"children": [child], "rotation": [half, 0, 0, half], "translation": [0, 0, 5]}
    )
    builder.tree["scenes"] = [{"nodes": [1]}]
    mesh = read_mesh(write(tmp_path, "a.glb", builder.glb()))
    # (x, y, 0) -> (2 x, -3 y, 0) -> turned by 90 degrees about x: (2 x, 0, -3 y) -> 5 up
    np.testing.assert_allclose(mesh.bounds, [[0, 0, 2], [2, 0, 5]], atol=1e-6)
    np.testing.assert_allclose(
        mesh.face_normals, [[0, -1, 0]] * 2, atol=1e-6
    )  # a mirror keeps the outside outside


def test_a_skinned_mesh_stands_in_the_pose_of_its_joints(tmp_path):
    builder = GltfBuilder()
    joints = np.array([[0, 1, 0, 0]] * 4, np.uint8)
    weights = np.float32([[1, 0, 0, 0]] * 2 + [[0, 1, 0, 0]] * 2)
    part = builder.add_primitive(JOINTS_0=joints, WEIGHTS_0=weights)
    builder.tree["accessors"][part["attributes"]["JOINTS_0"]]["normalized"] = False
    builder.add_node(part, skin=0, translation=[50, 0, 0])  # a skinned mesh goes with its joints alone
    builder.tree["nodes"] += [{"translation": [0, 0, 1]}, {"translation": [0, 4, 1]}]
    inverse = np.tile(np.eye(4, dtype=np.float32).reshape(1, 16), (2, 1))
    view = builder.add_view(inverse.tobytes())
    builder.tree["accessors"].append({"bufferView": view, "componentType": 5126, "count": 2, "type": "MAT4"})
    builder.tree["skins"] = [{"joints": [1, 2], "inverseBindMatrices": len(builder.tree["accessors"]) - 1}]
    mesh = read_mesh(write(tmp_path, "a.glb", builder.glb()))
    np.testing.assert_allclose(mesh.bounds, [[0, 0, 1], [1, 5, 1]], atol=1e-6)


def test_what_hangs_on_a_joint_belongs_to_its_limbs(tmp_path):
    builder = GltfBuilder()
    joints, weights = np.zeros((4, 4), np.uint8), np.float32([[1, 0, 0, 0]] * 4)
    skin = builder.add_primitive(JOINTS_0=joints, WEIGHTS_0=weights)
    builder.tree["accessors"][skin["attributes"]["JOINTS_0"]]["normalized"] = False
    builder.add_node(skin, skin=0)
    builder.add_node(builder.add_primitive(), name="axe")
    builder.tree["nodes"] += [
        {"name": "chest", "children": [3]},
        {"name": "upperarm.l", "children": [4]},
        {"name": "hand.l", "children": [1]},
    ]
    builder.tree["skins"] = [{"joints": [2, 3, 4]}]
    builder.tree["scenes"] = [{"nodes": [0, 2]}]
    axe = read_named_parts(write(tmp_path, "a.glb", builder.glb()))[-1]
    assert axe.names == ("axe", "left hand", "left arm")


def test_sparse_accessors_move_the_vertices_that_they_name(tmp_path):
    builder = GltfBuilder()
    part = builder.add_primitive()
    index, value = (
        builder.add_view(np.array([2], np.uint8).tobytes()),
        builder.add_view(np.float32([3, 3, 0]).tobytes()),
    )
    builder.tree["accessors"][part["attributes"]["POSITION"]]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": index, "componentType": 5121},
        "values": {"bufferView": value},
    }
    builder.add_node(part)
    np.testing.assert_allclose(read_mesh(write(tmp_path, "a.glb", builder.glb())).bounds[1], [3, 3, 0])


def compress(positions, faces, texture_coordinates) -> tuple[GltfBuilder, int]:
    """A file whose mesh is compressed by Google's own encoder, and the view that holds it."""
    DracoPy = pytest.importorskip("DracoPy")
    data = DracoPy.encode(positions, faces, quantization_bits=16, tex_coord=texture_coordinates.astype(float))
    packed = {each["attribute_type"]: each["unique_id"] for each in DracoPy.decode(data).attributes}
    kinds = DracoPy.AttributeType
    builder = GltfBuilder()
    material = builder.add_material(
        texture=builder.add_texture(np.uint8([[[255, 0, 0], [0, 0, 255]]])), doubleSided=True
    )
    part = builder.add_primitive(positions, faces.ravel(), material, TEXCOORD_0=texture_coordinates)
    for accessor in builder.tree["accessors"]:
        del accessor["bufferView"]
    names = {"POSITION": packed[kinds.POSITION], "TEXCOORD_0": packed[kinds.TEX_COORD]}
    view = builder.add_view(data)
    part["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": names}}
    builder.add_node(part, translation=[0, 0, 5])
    builder.tree["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return builder, view


def make_hills() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices of a hilly square, its triangles, and texture coordinates."""
    u, v = (each.ravel() for each in np.mgrid[0:1:9j, 0:1:9j])
    k = np.arange(81).reshape(9, 9)
    halves = (k[:-1, :-1], k[1:, :-1], k[1:, 1:]), (k[:-1, :-1], k[1:, 1:], k[:-1, 1:])
    faces = np.concatenate([np.stack(each, -1).reshape(-1, 3) for each in halves]).astype(np.uint16)
    heights = np.sin(5 * u) * np.cos(3 * v)
    return np.stack([u, heights, v], -1).astype(np.float32), faces, np.stack([u, v], -1).astype(np.float32)


def test_draco_is_read_as_the_same_mesh_uncompressed(tmp_path):
    positions, faces, coordinates = make_hills()
    builder, _ = compress(positions, faces, coordinates)
    (part,) = read_parts(write(tmp_path, "a.glb", builder.glb()))
    assert part.faces.shape == faces.shape
    # Vertices may come in another order; the triangles are the same ones, to the encoder's 16 bits.
    corners = np.sort(part.vertices[part.faces].mean(1) - [0, 0, 5], axis=0)
    np.testing.assert_allclose(corners, np.sort(positions[faces].mean(1), axis=0), atol=1e-4)
    count = len(part.faces)
    colours = part.look.evaluate(part.faces, np.arange(count), np.full((count, 3), 1 / 3))
    middles = part.vertices[part.faces].mean(1)[:, 0]
    red, blue = colours[middles < 0.2], colours[middles > 0.8]
    assert (red[:, 0] > red[:, 2]).all() and (blue[:, 2] > blue[:, 0]).all()


@pytest.mark.parametrize("kind", ["cut", "count", "absent"])
def test_broken_draco_is_refused_in_words(tmp_path, monkeypatch, kind):
    builder, view = compress(*make_hills())
    place = builder.tree["bufferViews"][view]
    if kind == "cut":
        place["byteLength"] //= 3
    if kind == "count":
        builder.tree["accessors"][0]["count"] += 1
    if kind == "absent":
        monkeypatch.setitem(sys.modules, "DracoPy", None)
    said = {"cut": "no valid glTF.*Draco", "count": "no valid glTF.*82", "absent": r"DracoPy.*\[draco\]"}
    with pytest.raises(UserError, match=said[kind]):
        read_parts(write(tmp_path, "a.glb", builder.glb()))


def test_compressed_gltf_is_refused_in_words(tmp_path):
    # As gltfpack writes it: the second buffer is what comes out, and nothing of it is in the file.
    tree = {
        "asset": {"version": "2.0"},
        "extensionsRequired": ["KHR_mesh_quantization", "EXT_meshopt_compression"],
        "buffers": [{"byteLength": 64, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}],
    }
    with pytest.raises(UserError, match="compressed.*meshopt.*without compression"):
        read_parts(write(tmp_path, "b.gltf", json.dumps(tree)))


# --- OBJ ----------------------------------------------------------------------------------------------------

SQUARES = (
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 3 0 0\nv 3 1 0\nv 2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl one\nf 1/1 2/2 3/3 4/4\nusemtl two\nf 5/1 6/2 7/3 8/4\n"
)


def test_each_group_of_an_obj_has_its_own_colour_or_picture(tmp_path):
    write(tmp_path, "a.mtl", "newmtl one\nKd 0.2 0.4 0.6\nnewmtl two\nKd 1 1 1\nmap_Kd two.png\n")
    write(tmp_path, "two.png", png(image([RED], [GREEN])))
    x, rgb = sampled(write(tmp_path, "a.obj", "mtllib a.mtl\n" + SQUARES))
    one = x[:, 0] < 1.5
    np.testing.assert_allclose(rgb[one], [[0.2, 0.4, 0.6]] * one.sum(), atol=2e-6)
    expected = np.array([GREEN, RED])[(x[~one, 1] > 0.5).astype(int)] / 255  # V runs upwards
    np.testing.assert_allclose(rgb[~one], expected, atol=2e-6)


def test_a_real_grey_is_kept_and_no_material_at_all_is_the_tone(tmp_path):
    write(tmp_path, "a.mtl", "newmtl one\nKd 0.4 0.4 0.4\n")
    x, rgb = sampled(write(tmp_path, "a.obj", "mtllib a.mtl\n" + SQUARES))
    one = x[:, 0] < 1.5
    np.testing.assert_allclose(rgb[one], 0.4, atol=2e-6)
    assert np.abs(rgb[~one] / TONE - 1).max() <= GRAIN + 1e-6


@pytest.mark.parametrize(
    "libraries", ["mtllib a.mtl\nmtllib b.mtl\n", "mtllib a.mtl b.mtl\n", "mtllib a.mtl\nmtllib the b.mtl\n"]
)
def test_options_of_a_map_and_several_libraries_are_understood(libraries, tmp_path):
    write(tmp_path, "a.mtl", "newmtl one\nmap_Kd -clamp on -s 2 1 1 -o 0.25 0 my picture.png\n")
    write(tmp_path, "the b.mtl" if "the b" in libraries else "b.mtl", "newmtl two\nKd 0 0 1\n")
    write(tmp_path, "my picture.png", png(image([RED, GREEN])))
    x, rgb = sampled(write(tmp_path, "a.obj", libraries + SQUARES))
    one = x[:, 0] < 1.5
    green = 2 * x[one, 0] + 0.25 > 0.5  # clamped beyond 1
    np.testing.assert_allclose(rgb[one], np.array([RED, GREEN])[green.astype(int)] / 255, atol=2e-6)
    same(rgb[~one], [0, 0, 1])


def test_a_broken_picture_is_said_and_its_kd_stays(tmp_path):
    write(tmp_path, "a.mtl", "newmtl one\nKd 0.2 0.4 0.6\nmap_Kd a.png\n")
    write(tmp_path, "a.png", b"no picture")
    with pytest.warns(UserWarning, match="colours are left out: a.png"):
        x, rgb = sampled(write(tmp_path, "a.obj", "mtllib a.mtl\n" + SQUARES))
    np.testing.assert_allclose(rgb[x[:, 0] < 1.5], [[0.2, 0.4, 0.6]] * (x[:, 0] < 1.5).sum(), atol=2e-6)


def test_colours_behind_the_coordinates_of_an_obj_are_its_vertices(tmp_path):
    write(tmp_path, "a.mtl", "newmtl m\nKd 0.75 0.75 0.75\n")  # some programs write both
    text = "mtllib a.mtl\nusemtl m\nv 0 0 0 1 0 0\nv 1 0 0 0 0 1\nv 1 1 0 0 0 1\nv 0 1 0 1 0 0\nf 1 2 3 4\n"
    x, rgb = sampled(write(tmp_path, "a.obj", text))
    same(rgb[:, 0], 1 - x[:, 0], 1e-5)
    same(rgb[:, 2], x[:, 0], 1e-5)


def test_vertices_may_be_indented_by_more_than_one_space(tmp_path):
    text = "v  0 0 0\nv  1 0 0 \nv \t0 1 0\nf 1 2 3\n"
    assert read_mesh(write(tmp_path, "a.obj", text)).area == pytest.approx(0.5)


# --- PLY, STL, OFF ------------------------------------------------------------------------------------------

PLY_HEAD = (
    "ply\nformat ascii 1.0\n{}element vertex 4\nproperty float x\nproperty float y\nproperty float z\n{}"
    "element face {}\nproperty list uchar int vertex_indices\n{}end_header\n"
)
RGB = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
CORNERS = ("0 0 0", "1 0 0", "1 1 0", "0 1 0")


def test_colours_of_vertices_and_of_faces_of_a_ply(tmp_path):
    colours = ["255 0 0", "0 0 255", "0 0 255", "255 0 0"]
    rows = "\n".join(f"{c} {k}" for c, k in zip(CORNERS, colours))
    text = PLY_HEAD.format("", RGB, 1, "") + rows + "\n4 0 1 2 3\n"
    x, rgb = sampled(write(tmp_path, "a.ply", text))
    same(rgb[:, 0], 1 - x[:, 0], 1e-5)  # mixed as they are stored
    text = PLY_HEAD.format("", "", 2, RGB) + "\n".join(CORNERS) + "\n3 0 1 2 9 80 200\n3 0 2 3 70 60 50\n"
    x, rgb = sampled(write(tmp_path, "b.ply", text))
    expected = np.where((x[:, 0] > x[:, 1])[:, None], [9, 80, 200], [70, 60, 50]) / 255
    np.testing.assert_allclose(rgb, expected, atol=2e-6)


def test_colours_of_faces_with_many_corners_go_with_their_triangles(tmp_path):
    """A triangle and a quad of one square, the quad first."""
    rows = "0 0 0\n1 0 0\n1 1 0\n0.5 0.5 0\n0 1 0\n"
    head = PLY_HEAD.format("", "", 2, RGB).replace("element vertex 4", "element vertex 5")
    text = head + rows + "4 0 3 2 4 200 10 10\n3 0 1 2 10 10 200\n"
    x, rgb = sampled(write(tmp_path, "a.ply", text))
    expected = np.where((x[:, 1] > x[:, 0])[:, None], [200, 10, 10], [10, 10, 200]) / 255
    np.testing.assert_allclose(rgb, expected, atol=2e-6)


def test_the_texture_of_a_ply_is_read_beside_it(tmp_path):
    write(tmp_path, "a.png", png(image([RED, GREEN], [BLUE, GREY])))
    uv = "property float s\nproperty float t\n"
    rows = "\n".join(f"{c} {c.rsplit(' ', 1)[0]}" for c in CORNERS)
    text = PLY_HEAD.format("comment TextureFile a.png\n", uv, 1, "") + rows + "\n4 0 1 2 3\n"
    x, rgb = sampled(write(tmp_path, "a.ply", text))
    expected = (
        image([RED, GREEN], [BLUE, GREY])[(x[:, 1] < 0.5).astype(int), (x[:, 0] > 0.5).astype(int)] / 255
    )
    np.testing.assert_allclose(rgb, expected, atol=2e-6)


def stl(header, bits):
    """Two triangles of a square and the two bytes of each."""
    corners = QUAD[QUAD_FACES].reshape(2, 9)
    faces = [struct.pack("<12fH", 0, 0, 1, *c, b) for c, b in zip(corners, bits)]
    return header.ljust(80, b"\0") + struct.pack("<I", 2) + b"".join(faces)


@pytest.mark.parametrize(
    ("header", "bits", "colours"),
    [
        (b"", [0x8000 | 31 << 10, 0x8000 | 31], [[1, 0, 0], [0, 0, 1]]),  # blue lowest, marked as valid
        (
            b"COLOR=\xff\x00\x00\xff",
            [0xFFFF, 31 << 10],
            [[1, 0, 0], [0, 0, 1]],
        ),  # the default, then blue highest
    ],
)
def test_colours_of_stl_faces_in_both_conventions(header, bits, colours, tmp_path):
    x, rgb = sampled(write(tmp_path, "a.stl", stl(header, bits)))
    same(rgb, np.array(colours)[(x[:, 1] > x[:, 0]).astype(int)], 1e-5)


def test_an_stl_without_colours_has_the_tone(tmp_path):
    assert np.abs(sampled(write(tmp_path, "a.stl", stl(b"", [0, 0])))[1] / TONE - 1).max() <= GRAIN + 1e-6


@pytest.mark.parametrize("colours", [("255 0 0 255", "0 0 255 255"), ("1.0 0 0 1", "0 0 1.0 1")])
def test_colours_of_vertices_of_an_off(colours, tmp_path):
    red, blue = colours
    rows = "\n".join(f"{c} {red if c[0] == '0' else blue}" for c in CORNERS)
    x, rgb = sampled(write(tmp_path, "a.off", f"COFF # coloured\n4 1 0\n{rows}\n4 0 1 2 3\n"))
    same(rgb[:, 0], 1 - x[:, 0], 1e-5)


# --- finding formats ----------------------------------------------------------------------------------------

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.mark.parametrize("suffix", [".obj", ".stl", ".ply", ".off", ".glb", ".gltf", ".bin"])
def test_formats_are_found_by_content_whatever_the_name(suffix, tmp_path):
    builder = GltfBuilder()
    builder.add_node(builder.add_primitive())
    contents = {
        "GLB": builder.glb(),
        "glTF": builder.gltf(),
        "OBJ": TRIANGLE.encode(),
        "STL": stl(b"solid", [0, 0]),
        "OFF": b"OFF\n4 1 0\n" + "\n".join(CORNERS).encode() + b"\n4 0 1 2 3\n",
        "PLY": (PLY_HEAD.format("", "", 1, "") + "\n".join(CORNERS) + "\n4 0 1 2 3\n").encode(),
    }
    assert set(contents) == {each.name for each in FORMATS}
    for name, content in contents.items():
        path = write(tmp_path, f"a{suffix}", content)
        assert find_mesh_format(content, path).name == name
        assert read_mesh(path).area == pytest.approx(0.5 if name == "OBJ" else 1.0)


def test_suffixes_of_formats_are_those_that_objects_may_have():
    from physagent_jax.scene.config.source import MESH_SUFFIXES

    assert sorted(suffix for each in FORMATS for suffix in each.suffixes) == sorted((".ply", *MESH_SUFFIXES))


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".obj"])
def test_gltf_prescribes_up_whatever_the_name(suffix, tmp_path):
    """glTF 2.0, section 3.4: +Y is up. OBJ prescribes nothing."""
    builder = GltfBuilder()
    builder.add_node(builder.add_primitive())
    for content, up in ((builder.glb(), "+y"), (builder.gltf(), "+y"), (TRIANGLE.encode(), None)):
        assert find_mesh_format(content, write(tmp_path, f"a{suffix}", content)).up == up


def test_colours_that_are_not_finite_are_told():
    with pytest.warns(UserWarning, match="1 colours of the mesh are not finite"):
        rgba = as_rgba(np.array([[0.5, np.nan, 1.0], [0.0, 1.0, 0.0]]))
    np.testing.assert_allclose(rgba, [[0.5, 0, 1, 1], [0, 1, 0, 1]])


@pytest.mark.parametrize("value", ["nan", "inf"])
def test_texture_coordinates_that_are_not_finite_are_told(value, tmp_path):
    """The triangle without them has its colour; the other one's U is read as 0."""
    write(tmp_path, "a.png", png(image([RED, GREEN], [BLUE, GREY])))
    uv = "property float s\nproperty float t\n"
    rows = "\n".join(f"{c} {value if c == CORNERS[1] else 0.75} 0.75" for c in CORNERS)
    text = PLY_HEAD.format("comment TextureFile a.png\n", uv, 2, "") + rows + "\n3 0 1 2\n3 0 2 3\n"
    with pytest.warns(UserWarning, match="1 texture coordinates of the mesh are not finite"):
        x, rgb = sampled(write(tmp_path, "a.ply", text))
    expected = np.where((x[:, 1] > x[:, 0])[:, None], GREEN, RED) / 255
    np.testing.assert_allclose(rgb, expected, atol=2e-6)
