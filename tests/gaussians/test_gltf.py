"""glTF with KHR_gaussian_splatting: files by hand, transforms of nodes, and what is written read again."""

import base64
import json

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import GaussianCloud, eval_sh
from physagent_jax.gaussians.covariance import covariance_matrices, quats_scales_to_covariances
from physagent_jax.gaussians.formats import find_format, read_head, read_splats
from physagent_jax.gaussians.formats.gltf import GLTF
from physagent_jax.gaussians.formats.gltf_writer import write_glb
from tests.gaussians.format_bytes import PREFIX, gaussian_values, glb, gltf_parts, smallest_three, spz
from tests.gaussians.test_spz import make_cloud

VALUES = gaussian_values()


def read(tmp_path, content, name="a.glb"):
    path = tmp_path / name
    path.write_bytes(content)
    return read_splats(path)


def covariances(cloud):
    return covariance_matrices(
        quats_scales_to_covariances(jnp.asarray(cloud.quats), jnp.asarray(cloud.scales))
    )


def matrices(values):
    """Covariances of attributes as the extension defines them."""
    C = Rotation.from_quat(values["ROTATION"]).as_matrix() * values["SCALE"][:, None, :]
    return C @ C.transpose(0, 2, 1)


def test_attributes_stand_for_what_the_extension_says(tmp_path):
    loaded = read(tmp_path, glb(*gltf_parts(VALUES)))
    cloud = loaded.cloud
    np.testing.assert_allclose(cloud.means, VALUES["POSITION"], rtol=1e-6)
    np.testing.assert_allclose(np.asarray(cloud.quats)[:, [1, 2, 3, 0]], VALUES["ROTATION"], atol=1e-6)
    np.testing.assert_allclose(cloud.scales, VALUES["SCALE"], rtol=1e-6)
    np.testing.assert_allclose(cloud.opacities[:, None], VALUES["OPACITY"], rtol=1e-6)
    for place, name in enumerate(["0_COEF_0", "1_COEF_0", "1_COEF_1", "1_COEF_2"]):
        np.testing.assert_allclose(cloud.sh[:, place], VALUES[f"SH_DEGREE_{name}"], rtol=1e-6)
    assert loaded.up == "+y" and loaded.format_name == GLTF.name


def test_integers_are_fractions_of_their_range(tmp_path):
    values = VALUES | {
        "ROTATION": np.array([[127, 0, 0, -127]] * 5, np.int8),
        "OPACITY": np.array([[0], [51], [102], [204], [255]], np.uint8),
        "SCALE": np.array([[65535, 13107, 0]] * 5, np.uint16),
    }
    cloud = read(tmp_path, glb(*gltf_parts(values))).cloud
    np.testing.assert_allclose(cloud.quats[0], np.array([-1, 1, 0, 0]) / np.sqrt(2), atol=1e-6)
    np.testing.assert_allclose(cloud.opacities, [0, 0.2, 0.4, 0.8, 1], atol=1e-6)
    np.testing.assert_allclose(cloud.scales[0], [1, 0.2, 0], atol=1e-6)


TURN = Rotation.from_rotvec([0.3, -1.1, 0.7])
NODES = {
    "turned and moved": [{"mesh": 0, "rotation": TURN.as_quat().tolist(), "translation": [1, 2, 3]}],
    "larger": [{"mesh": 0, "rotation": TURN.as_quat().tolist(), "scale": [2, 2, 2]}],
    "stretched": [{"mesh": 0, "rotation": TURN.as_quat().tolist(), "scale": [1, 2, 0.5]}],
    "below another": [
        {"children": [1], "scale": [1, 3, 1], "translation": [0, 0, 5]},
        {"mesh": 0, "matrix": np.eye(4)[[1, 2, 0, 3]].ravel().tolist()},
    ],
}


def find_matrix(nodes):
    """Product of the nodes' matrices, outermost first."""
    whole = np.eye(4)
    for node in nodes:
        own = np.eye(4)
        if "matrix" in node:
            own = np.reshape(node["matrix"], (4, 4)).T
        own[:3, :3] = own[:3, :3] @ Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix()
        own[:3, :3] = own[:3, :3] @ np.diag(node.get("scale", [1, 1, 1]))
        own[:3, 3] += node.get("translation", [0, 0, 0])
        whole = whole @ own
    return whole


@pytest.mark.parametrize("name", NODES)
def test_nodes_move_turn_and_stretch_gaussians(tmp_path, name):
    """Sigma = M C C^T M^T, the specification's formula."""
    cloud = read(tmp_path, glb(*gltf_parts(VALUES, nodes=NODES[name]))).cloud
    whole = find_matrix(NODES[name])
    M = whole[:3, :3]
    np.testing.assert_allclose(cloud.means, VALUES["POSITION"] @ M.T + whole[:3, 3], rtol=1e-5, atol=1e-6)
    expected = M @ matrices(VALUES) @ M.T
    np.testing.assert_allclose(covariances(cloud), expected, rtol=2e-5, atol=1e-6 * np.abs(expected).max())


def test_harmonics_turn_with_the_node(tmp_path):
    still = read(tmp_path, glb(*gltf_parts(VALUES))).cloud
    moved = read(tmp_path, glb(*gltf_parts(VALUES, nodes=NODES["turned and moved"]))).cloud
    directions = np.random.default_rng(0).normal(size=(5, 3))
    directions = np.float32(directions / np.linalg.norm(directions, axis=1, keepdims=True))
    seen = eval_sh(moved.sh, jnp.asarray(np.float32(TURN.apply(directions))))
    np.testing.assert_allclose(seen, eval_sh(still.sh, jnp.asarray(directions)), atol=2e-6)


def test_several_parts_are_one_cloud(tmp_path):
    nodes = [{"children": [1, 2]}, {"mesh": 0}, {"mesh": 0, "translation": [9, 0, 0]}]
    cloud = read(tmp_path, glb(*gltf_parts(VALUES, nodes=nodes))).cloud
    assert cloud.count == 10
    found = np.sort(np.asarray(cloud.means)[:, 0])
    np.testing.assert_allclose(
        found, np.sort([*VALUES["POSITION"][:, 0], *(VALUES["POSITION"][:, 0] + 9)]), rtol=1e-5
    )


@pytest.mark.parametrize("inside", [True, False])
def test_text_gltf_with_its_buffer_beside_or_inside(tmp_path, inside):
    tree, buffer = gltf_parts(VALUES)
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode() if inside else "a.bin"
    tree["buffers"][0]["uri"] = uri
    (tmp_path / "a.bin").write_bytes(buffer)
    cloud = read(tmp_path, json.dumps(tree).encode(), "a.gltf").cloud
    np.testing.assert_allclose(cloud.means, VALUES["POSITION"], rtol=1e-6)


@pytest.mark.parametrize("suffix", ["_spz_2", "_spz"])
def test_gaussians_compressed_as_spz_face_as_gltf_does(tmp_path, suffix):
    """SPZ's axes point right, up and back, those of glTF left, up and front: half a turn about y."""
    gaussian = dict(position=(4096, 8192, -2048), alpha=255, colour=(128, 0, 255), scale=(160, 144, 128),
                    rotation=smallest_three(3, [(0, 100), (1, 200), (0, 300)]))  # fmt: skip
    packed = spz(3, [gaussian])
    plain = read(tmp_path, packed, "a.spz").cloud
    tree, buffer = gltf_parts(VALUES)
    name = f"KHR_gaussian_splatting_compression{suffix}"
    tree["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"] = {
        "extensions": {name: {"bufferView": len(tree["bufferViews"])}}
    }
    tree["bufferViews"].append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(packed)})
    tree["buffers"][0]["byteLength"] += len(packed)
    cloud = read(tmp_path, glb(tree, buffer + packed)).cloud
    np.testing.assert_array_equal(cloud.means[0], [-1, 2, 0.5])
    flip = np.diag([-1.0, 1.0, -1.0])
    np.testing.assert_allclose(
        covariances(cloud)[0], flip @ covariances(plain)[0] @ flip, rtol=1e-5, atol=1e-9
    )


def test_a_mesh_without_the_extension_is_none(tmp_path):
    tree, buffer = gltf_parts(VALUES, used=False)
    del tree["meshes"][0]["primitives"][0]["extensions"]
    tree["meshes"][0]["primitives"][0]["attributes"] = {"POSITION": 0}
    (tmp_path / "a.glb").write_bytes(glb(tree, buffer))
    assert find_format(read_head(tmp_path / "a.glb"), tmp_path / "a.glb") is None


def changed(change):
    tree, buffer = gltf_parts(VALUES)
    change(tree)
    return glb(tree, buffer)


def primitive(tree):
    return tree["meshes"][0]["primitives"][0]


DAMAGE = {
    "mirrors or flattens": lambda t: t["nodes"][0].update(scale=[-1, 1, 1]),
    "flattens": lambda t: t["nodes"][0].update(scale=[1, 0, 1]),
    "two places": lambda t: t["nodes"][0].update(children=[0]),
    "no attribute KHR_gaussian_splatting:SCALE": lambda t: primitive(t)["attributes"].pop(PREFIX + "SCALE"),
    "no attribute KHR_gaussian_splatting:SH_DEGREE_1_COEF_1": lambda t: primitive(t)["attributes"].pop(
        PREFIX + "SH_DEGREE_1_COEF_1"
    ),
    "VEC3": lambda t: primitive(t)["attributes"].update({PREFIX + "ROTATION": 0}),
    "no accessors": lambda t: primitive(t)["attributes"].update(POSITION=99),
    "announces more than it holds": lambda t: t["accessors"][0].update(count=10**9),
    "bufferViews": lambda t: t["bufferViews"][0].update(byteLength=10**9),
    "sparse": lambda t: t["accessors"][0].update(sparse={}),
    "compressed in a way": lambda t: t["bufferViews"][0].update(extensions={"EXT_meshopt_compression": {}}),
    "outside its folder": lambda t: t["buffers"][0].update(uri="../a.bin"),
    "`count` is -5": lambda t: t["accessors"][0].update(count=-5),
    "`primitives` is int": lambda t: t["meshes"][0].update(primitives=3),
    "holds no Gaussians": lambda t: t["nodes"][0].pop("mesh"),
    "lengths": lambda t: t["accessors"][1].update(count=4),
}


@pytest.mark.parametrize("message", DAMAGE)
def test_damage_is_refused_in_one_line(tmp_path, message):
    with pytest.raises(UserError, match=message) as refused:
        read(tmp_path, changed(DAMAGE[message]))
    assert "\n" not in str(refused.value)


def test_logarithms_are_refused(tmp_path):
    values = VALUES | {"SCALE": np.log(VALUES["SCALE"])}
    with pytest.raises(UserError, match="scales that are none.*plain values"):
        read(tmp_path, glb(*gltf_parts(values)))


def test_a_thousand_nodes_cannot_multiply_a_file(tmp_path):
    values = gaussian_values(200)
    nodes = [{"children": list(range(1, 3000))}, *({"mesh": 0} for _ in range(2999))]
    with pytest.raises(UserError, match="more than .* Gaussians in"):
        read(tmp_path, glb(*gltf_parts(values, nodes=nodes)))


@pytest.mark.parametrize("degree", [0, 3])
def test_what_is_written_is_read_as_it_was(tmp_path, degree):
    cloud = make_cloud(degree=degree)
    write_glb(tmp_path / "a.glb", cloud)
    loaded = read_splats(tmp_path / "a.glb")
    for name in ("means", "scales", "opacities", "sh"):
        np.testing.assert_array_equal(getattr(loaded.cloud, name), getattr(cloud, name))
    np.testing.assert_allclose(loaded.cloud.quats, cloud.quats, atol=1e-7)
    assert loaded.up == "+y"


def test_a_far_origin_is_kept_exactly(tmp_path):
    cloud, origin = make_cloud(50), np.array([4.2e6, -1e5, 0.125])
    write_glb(tmp_path / "a.glb", cloud, origin=origin)
    loaded = read_splats(tmp_path / "a.glb")
    expected = np.asarray(cloud.means, np.float64) + origin
    np.testing.assert_allclose(
        np.asarray(loaded.cloud.means, np.float64) + loaded.origin, expected, atol=1e-6
    )


def test_viewers_without_the_extension_get_coloured_points(tmp_path):
    """A grey of 0.5 in sRGB is 0.214 in linear light (IEC 61966-2-1)."""
    values = np.zeros((1, 3)), [[1, 0, 0, 0]], np.ones((1, 3)), [0.4], np.zeros((1, 1, 3))
    cloud = GaussianCloud(*map(np.float32, values))
    write_glb(tmp_path / "a.glb", cloud)
    data = (tmp_path / "a.glb").read_bytes()
    length = int.from_bytes(data[12:16], "little")
    tree = json.loads(data[20 : 20 + length])
    accessor = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]]
    start = 28 + length + tree["bufferViews"][accessor["bufferView"]]["byteOffset"]
    assert list(data[start : start + 4]) == [55, 55, 55, 102] and accessor["normalized"]
    assert len(data) == int.from_bytes(data[8:12], "little") and length % 4 == 0
