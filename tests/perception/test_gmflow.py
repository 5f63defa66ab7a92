"""GMFlow in Flax: the numbers of the published code, and tracks through turns that lose other flow."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial import KDTree

from benchmarks.agents.models import MODELS, check_hash
from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.backends.flow import FlowTracker
from tests.perception import make_gmflow_reference as reference

for package in ("flax.nnx", "safetensors"):
    pytest.importorskip(package, reason="needs the extra `gmflow`")

from safetensors.numpy import save_file  # noqa: E402

from physagent_jax.perception.backends import gmflow  # noqa: E402
from physagent_jax.perception.gmflow.checkpoint import make_network, read_tensors  # noqa: E402

EXPECTED = np.load(reference.EXPECTED)


def ask(network, pair):
    """Flow both ways, shape (2, height, width, 2)."""
    first, second = (each[None].astype(np.float32) / np.float32(255) for each in pair)
    graph, weights = gmflow.nnx.split(network)
    return np.concatenate(gmflow.match_both_ways(graph, weights, first, second))


@pytest.fixture(scope="module")
def checkpoint():
    """The published weights."""
    file = MODELS["gmflow"].find()
    if file is None:
        pytest.skip("no checkpoint: `python -m benchmarks.agents.models gmflow` fetches it")
    check_hash(file, MODELS["gmflow"].sha256)
    return str(file)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """A file of random weights."""
    path = tmp_path_factory.mktemp("gmflow") / "tiny.safetensors"
    save_file(reference.draw_weights(*reference.TINY["one scale"]), path)
    return path


@pytest.mark.parametrize("name", reference.TINY)  # 4 s of processor time: most of it compiles the network
def test_a_random_network_says_what_the_published_code_says(name):
    network = make_network(reference.draw_weights(*reference.TINY[name]))
    assert (network.config.scales, network.config.factor) == reference.TINY[name]
    assert (network.config.layers, network.config.expansion) == (reference.LAYERS, reference.EXPANSION)
    found = ask(network, reference.draw_pair(0, 64, 96))
    np.testing.assert_allclose(reference.thin(found, 4), EXPECTED[name], atol=1e-3)


@pytest.mark.slow
def test_the_published_weights_say_what_the_published_code_says(checkpoint):
    """The same numbers, but where places are alike: there single precision decides, in the published code too."""
    network = make_network(read_tensors(Path(checkpoint)))
    assert network.config.multiple == 32
    for seed, expected in enumerate(EXPECTED["checkpoint"]):
        found = ask(network, reference.draw_pair(seed, 128, 128))
        off = np.abs(reference.thin(found, reference.FEW) - expected)
        assert np.median(off) < 1e-4 and np.percentile(off, 95) < 1e-3 and off.max() < 0.01, seed


@pytest.mark.slow
def test_the_published_weights_find_a_turn_that_loses_other_flow(checkpoint):
    frames, masks, turn = draw_turning(2, 40.0)
    for tracker, finds in ((FlowTracker(), False), (gmflow.GmflowTracker(checkpoint), True)):
        error, visible, _ = follow(tracker, frames, masks, turn)
        assert (visible[1].mean() > 0.9 and np.median(error[1]) < 0.2) == finds


def draw_turning(count, degrees):
    """A disc whose red and green are its own places and whose blue has fine texture; it turns and goes right.

    Returns:
        Pictures, masks, and the affine maps from the first picture.
    """
    y, x = np.mgrid[:200, :260] + 0.5
    own = np.stack([x - 90, y - 100], -1)
    grain = cv2.resize(np.random.default_rng(0).uniform(0, 255, (50, 65)).astype(np.float32), (260, 200))
    picture = np.dstack([own[..., 0] * 1.7 + 127, own[..., 1] * 1.7 + 127, grain])
    disc = np.linalg.norm(own, axis=-1) < 70
    picture = np.where(disc[..., None], picture, 255).clip(0, 255).astype(np.uint8)
    frames, masks, maps = [], [], []
    for k in range(count):
        turned = cv2.getRotationMatrix2D((90.0, 100.0), k * degrees, 1.0)  # of places, not of pixels' indices
        turned[:, 2] += (20.0 * k, 0)
        indices = turned.copy()
        indices[:, 2] += turned[:, :2] @ (0.5, 0.5) - 0.5
        frames.append(
            cv2.warpAffine(
                picture, indices, (260, 200), borderMode=cv2.BORDER_CONSTANT, borderValue=(255,) * 3
            )
        )
        masks.append(cv2.warpAffine(disc.astype(np.uint8), indices, (260, 200)) > 0)
        maps.append(turned)
    return np.stack(frames), np.stack(masks), maps


def follow(tracker, frames, masks, maps):
    """Errors of a grid of points [px], which of them are visible, and confidence; shape (T, N) each."""
    x, y = (each.ravel() for each in np.meshgrid(np.arange(45, 136, 9), np.arange(55, 146, 9)))
    points = np.stack([x, y], 1)[np.hypot(x - 90, y - 100) < 55].astype(float)
    found = tracker.encode(frames, masks).track(np.insert(points, 0, 0, axis=1))
    true = np.stack([points @ each[:, :2].T + each[:, 2] for each in maps])
    return np.linalg.norm(found.xy - true, axis=-1), found.visible, found.confidence


def match_by_colour(graph, weights, first, second):
    """A perfect matcher of `draw_turning`: to the pixel of most similar red and green, a pixel coarse, both ways."""

    def search(a, b):
        tree = KDTree(b[0, ..., :2].reshape(-1, 2))
        index = tree.query(a[0, ..., :2].reshape(-1, 2))[1].reshape(a.shape[1:3])
        y, x = np.mgrid[: a.shape[1], : a.shape[2]]
        flow = np.stack([index % a.shape[2] - x, index // a.shape[2] - y], -1)
        return cv2.GaussianBlur(flow.astype(np.float32), (5, 5), 0)[None]

    return search(first, second), search(second, first)


def test_tracks_go_on_through_turns_and_stay_comparable_with_the_first_frame(tiny, monkeypatch):
    """120 degrees in three steps, by a matcher that is coarse; other flow loses the first."""
    monkeypatch.setattr(gmflow, "match_both_ways", match_by_colour)
    monkeypatch.setattr(gmflow, "SIDE", 96)
    frames, masks, maps = draw_turning(4, 40.0)
    error, visible, sure = follow(gmflow.GmflowTracker(str(tiny)), frames, masks, maps)
    assert visible.mean(1).min() > 0.9 and np.median(error[-1]) < 0.15
    assert np.percentile(error[-1][visible[-1]], 95) < 1
    assert ((sure > 0) == visible).all() and sure.max() == 1.0
    assert not follow(FlowTracker(), frames, masks, maps)[1][1].any()


def test_what_the_way_back_does_not_confirm_is_invisible(tiny, monkeypatch):
    """A matcher that finds no way back: nothing is followed, and nothing is said of later frames."""

    def match(graph, weights, first, second):
        forth, back = match_by_colour(graph, weights, first, second)
        return forth, back + 20

    monkeypatch.setattr(gmflow, "match_both_ways", match)
    monkeypatch.setattr(gmflow, "SIDE", 96)
    frames, masks, maps = draw_turning(3, 40.0)
    _, visible, sure = follow(gmflow.GmflowTracker(str(tiny)), frames, masks, maps)
    assert visible[0].all() and not visible[1:].any() and not sure[1:].any()


def test_a_run_chooses_it_by_name_and_weights(tiny, tmp_path):
    tracker = make_backends(tracker=("gmflow", {"weights": str(tiny)})).tracker
    assert tracker.name.startswith("GmflowTracker ") and len(tracker.name.split()[1]) == 12
    others = reference.draw_weights(*reference.TINY["one scale"])
    others["upsampler.2.bias"] = others["upsampler.2.bias"] + 1
    save_file(others, tmp_path / "other.safetensors")
    assert gmflow.GmflowTracker(str(tmp_path / "other.safetensors")).name != tracker.name


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda w: w.pop("backbone.conv2.weight"), "another network than GMFlow"),
        (lambda w: w.pop("transformer.layers.1.self_attn.merge.weight"), "lacks a weight of GMFlow"),
        (
            lambda w: w.update({"refine.conv.weight": np.zeros(3, np.float32)}),
            "not of GMFlow .got refine.conv.weight",
        ),
        (
            lambda w: w.update({"backbone.conv1.weight": np.zeros((64, 4, 7, 7), np.float32)}),
            "must have the shape",
        ),
    ],
)
def test_weights_of_another_network_are_refused(tmp_path, change, words):
    weights = reference.draw_weights(*reference.TINY["one scale"])
    change(weights)
    save_file(weights, tmp_path / "a.safetensors")
    with pytest.raises(UserError, match=words):
        gmflow.GmflowTracker(str(tmp_path / "a.safetensors"))


def test_files_that_are_missing_or_no_checkpoint_are_refused(tmp_path):
    (tmp_path / "a.safetensors").write_bytes(b"abc")
    for weights, words in (
        ("absent.safetensors", "there is no checkpoint"),
        ("absent.pth", "there is no checkpoint"),
        ("a.safetensors", "the weights cannot be read"),
    ):
        with pytest.raises(UserError, match=words):
            gmflow.GmflowTracker(str(tmp_path / weights))
    with pytest.raises(UserError, match="must be the path of a file"):
        gmflow.GmflowTracker(7)  # type: ignore[arg-type]
    with pytest.raises(UserError, match="`search_round_trip` of the tracker gmflow must be above 0"):
        gmflow.GmflowTracker("absent.pth", search_round_trip=-1.0)
