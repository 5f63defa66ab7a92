"""Real captures in several formats, made by other programs, against each other within their quantisation."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats import FORMATS, find_format, read_head, read_splats
from physagent_jax.gaussians.formats.points import PLY_POINTS
from physagent_jax.gaussians.formats.unread import UNREAD
from physagent_jax.scene.placement import find_up_rotation

COLOUR_OF_SH = 0.28209479177387814


def covariances(cloud, turn=None):
    """Covariances in float64, shape (n, 3, 3), turned."""
    axes = Rotation.from_quat(np.asarray(cloud.quats, np.float64), scalar_first=True).as_matrix()
    if turn is not None:
        axes = turn @ axes
    M = axes * np.asarray(cloud.scales, np.float64)[:, None, :]
    return M @ M.transpose(0, 2, 1)


def differences(one, other):
    """Relative differences of covariances, shape (n,)."""
    return np.linalg.norm(one - other, axis=(1, 2)) / np.linalg.norm(other, axis=(1, 2))


def colours(cloud):
    return np.clip(np.asarray(cloud.sh[:, 0]) * COLOUR_OF_SH + 0.5, -0.4, 1.4)  # what a byte of SPZ reaches


def test_the_guitar_stands_as_spz_as_it_stands_as_ply(shared_data):
    """The PLY is y-down as captured; the SPZ, made of it, keeps to the format's y-up."""
    spz = read_splats(shared_data / "guitar.spz")
    ply = read_splats(shared_data / "guitar_sh0.ply")
    assert spz.up == "+y" and spz.count_in_file == ply.count_in_file
    one, other = find_up_rotation("+y"), find_up_rotation("-y")
    means = np.asarray(spz.cloud.means) @ one.T, np.asarray(ply.cloud.means) @ other.T
    assert np.abs(means[0] - means[1]).max() <= 0.5 / 4096 + 1e-6
    held = (np.asarray(ply.cloud.scales) > np.exp(-10)).all(axis=1)  # what SPZ can hold
    assert held.mean() > 0.9
    apart = differences(covariances(spz.cloud, one)[held], covariances(ply.cloud, other)[held])
    assert np.median(apart) < 0.05 and apart.max() < 0.1  # scales in steps of 1/16 of the logarithm
    assert np.abs(spz.cloud.opacities - ply.cloud.opacities).max() <= 0.5 / 255 + 1e-3
    assert np.abs(colours(spz.cloud) - colours(ply.cloud)).max() <= COLOUR_OF_SH * 0.5 / (255 * 0.15) + 1e-4


def test_the_guitar_is_the_same_compressed(shared_data):
    """The PLY was made of the compressed one, less what is nearly transparent: another order, the same Gaussians."""
    compressed = read_splats(shared_data / "guitar.compressed.ply", opacity_threshold=0.0205).cloud
    plain = read_splats(shared_data / "guitar_sh0.ply").cloud
    apart, index = cKDTree(np.asarray(compressed.means)).query(np.asarray(plain.means))
    same = np.flatnonzero(apart < 1e-6)
    assert len(same) > 0.999 * plain.count
    index = index[same]
    tied = differences(covariances(compressed)[index], covariances(plain)[same]) < 1e-4
    assert tied.mean() > 0.999  # the others share their place with another Gaussian
    index, same = index[tied], same[tied]
    assert np.abs(compressed.sh[index] - plain.sh[same]).max() < 1e-5
    # 1/400: opacities of the PLY were kept within logits of 6.
    assert np.abs(compressed.opacities[index] - plain.opacities[same]).max() < 1 / 400


@pytest.mark.parametrize("name", ["object.spz", "object.splat"])
def test_made_files_agree_with_their_ply(shared_data, name):
    folder = shared_data / "reports" / "in"
    if not folder.is_dir():
        pytest.skip("the folder of made files is not present")
    plain, other = read_splats(folder / "plain.ply").cloud, read_splats(folder / name).cloud
    step = 0.5 / 4096 if name.endswith("spz") else 0.0
    assert np.abs(other.means - plain.means).max() <= step + 1e-7
    assert np.median(differences(covariances(other), covariances(plain))) < 0.05
    assert np.abs(colours(other) - colours(plain)).max() < 0.01
    assert np.abs(other.opacities - plain.opacities).max() <= 0.5 / 255 + 1e-6


def test_every_known_file_is_of_one_format(shared_data):
    """No format claims another's file; only that of PLYs without Gaussians, which comes after, takes any PLY."""
    files = [
        *shared_data.glob("*.ply"),
        *shared_data.glob("*.spz"),
        *(shared_data / "reports" / "in").glob("object.*"),
    ]
    assert files
    for path in files:
        claims = [f.name for f in FORMATS if f is not PLY_POINTS and f.matches(read_head(path))]
        assert len(claims) == 1, (path, claims)


# --- formats that are not read -----------------------------------------------------------------------------


def ksplat():
    head = bytearray(4096 + 1024)
    head[:22] = b"\0\1\0\0" + b"".join(n.to_bytes(4, "little") for n in (1, 1, 100, 100)) + b"\1\0"
    return bytes(head)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.ksplat", ksplat(), "ksplat.*not read.*splat-transform in.ksplat out.ply"),
        (
            "lod-meta.json",
            b'{"version": 1, "lodLevels": 4, "filenames": ["0_0/meta.json"]}',
            "streamed SOG.*meta.json of one",
        ),
        ("a.spx", b"spx\2" + bytes(200), "spx.*gsbox"),
    ],
)
def test_known_formats_that_are_not_read_say_how_to_convert(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    assert find_format(read_head(path), path) in UNREAD
    with pytest.raises(UserError, match=message) as refused:
        read_splats(path)
    assert "\n" not in str(refused.value)
