"""The adapter of CoTracker, with a checkout whose predictor is a stand-in: it has the calls of the real one.

Its model follows the brightest pixel, which its queries must name in indices of pixels.
"""

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import TRACKERS
from tests.perception import tiny_models

HUBCONF = """
import torch

class StandInModel(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.confidence = torch.nn.Parameter(torch.zeros(()))
        self.asked = []

    def forward(self, video, queries, iters=4):
        self.asked.append((tuple(video.shape), queries[0].clone()))
        batch, count, _, height, width = video.shape
        flat = video.mean(2).reshape(count, -1).argmax(1)
        tracks = torch.stack([flat % width, flat // width], -1).float()[None, :, None].repeat(1, 1, queries.shape[1], 1)
        shown = torch.ones(batch, count, queries.shape[1])
        shown[:, -1] = 0.2
        return tracks, shown, shown * self.confidence, None

class StandInPredictor(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.model = StandInModel()

    def forward(self, video, queries=None, segm_mask=None, grid_size=0, grid_query_frame=0, backward_tracking=False):
        more = torch.cat([queries, torch.zeros(1, 36, 3)], 1)
        tracks, visible, *_ = self.model.forward(video=video, queries=more, iters=6)
        count = queries.shape[1]
        return tracks[:, :, :count], visible[:, :, :count] > 0.9

def cotracker3_offline(*, pretrained=True, **kwargs):
    assert not pretrained, "this would download"
    return StandInPredictor()
"""
SIZE = 5, 20, 30  # frames, height and width


@pytest.fixture
def checkout(tmp_path):
    tiny_models.import_torch()
    import torch

    folder = tmp_path / "co-tracker"
    (folder / "checkpoints").mkdir(parents=True)
    (folder / "hubconf.py").write_text(HUBCONF)
    torch.save({"confidence": torch.tensor(0.5)}, folder / "checkpoints" / "scaled_offline.pth")
    return folder


def make_frames():
    frames = np.zeros((*SIZE, 3), np.uint8)
    for t in range(SIZE[0]):
        frames[t, 4 + t, 10 + 2 * t] = 255
    return frames


def make_tracker(folder, **options):
    return TRACKERS.make(("cotracker", {"path": str(folder), "device": "cpu", **options}))


def test_positions_have_pixel_centres_at_one_half(checkout):
    tracker = make_tracker(checkout)
    tracks = tracker.encode(make_frames(), np.ones(SIZE, bool)).track(np.array([[0.0, 10.5, 4.5]]))
    np.testing.assert_allclose(tracks.xy[:, 0], [(10.5 + 2 * t, 4.5 + t) for t in range(5)])
    shape, queries = tracker._predictor.model.asked[0]
    assert shape == (1, 5, 3, 20, 30) and queries[0].tolist() == [0, 10, 4]
    assert tracker.name == "cotracker:scaled_offline"


def test_visibility_is_the_predictors_and_confidence_the_models(checkout):
    tracks = (
        make_tracker(checkout).encode(make_frames(), np.ones(SIZE, bool)).track(np.array([[0.0, 10.5, 4.5]]))
    )
    assert tracks.visible[:, 0].tolist() == [True] * 4 + [False]
    np.testing.assert_allclose(tracks.confidence[:, 0], [0.5] * 4 + [0.1])  # 0.5 is in the weights' file


def test_points_go_in_chunks_and_only_frames_of_use_are_looked_at(checkout):
    tracker = make_tracker(checkout, points=4)
    queries = np.array([[1.0, 12.5, 5.5]] * 6 + [[2.0, 14.5, 6.5]] * 3)
    tracks = tracker.encode(make_frames(), np.ones(SIZE, bool)).track(queries, until=4)
    asked = tracker._predictor.model.asked
    assert [len(each) - 36 for _, each in asked] == [4, 4, 1]
    assert all(shape[1] == 3 for shape, _ in asked) and asked[0][1][0].tolist() == [0, 12, 5]
    assert asked[1][1][3].tolist() == [1, 14, 6]
    assert not tracks.visible[0].any() and not tracks.visible[4].any()
    assert tracks.visible[1, :6].all() and not tracks.visible[1, 6:].any() and tracks.visible[2].all()
    np.testing.assert_allclose(tracks.xy[2], [(14.5, 6.5)] * 9)


def test_no_points_and_no_frames_are_no_work(checkout):
    clip = make_tracker(checkout).encode(make_frames(), np.ones(SIZE, bool))
    assert clip.track(np.zeros((0, 3))).xy.shape == (5, 0, 2)
    assert not clip.track(np.array([[4.0, 1.5, 1.5]]), until=4).visible.any()
    assert make_tracker(checkout)._predictor.model.asked == []


def test_what_is_missing_or_does_not_fit_is_one_line(checkout, tmp_path, monkeypatch):
    import torch

    monkeypatch.setenv("PHYSAGENT_MODELS", str(tmp_path / "models"))
    with pytest.raises(UserError, match="no checkout of co-tracker.*models/co-tracker.*physagent models"):
        TRACKERS.make("cotracker")
    with pytest.raises(UserError, match="no checkpoint of `cotracker`.*nowhere.pth"):
        make_tracker(checkout, weights=str(tmp_path / "nowhere.pth"))
    with pytest.raises(UserError, match="`points` must be"):
        make_tracker(checkout, points=0)
    with pytest.raises(UserError, match="`path` of `cotracker` must be a path"):
        TRACKERS.make(("cotracker", {"path": 3}))
    other = tmp_path / "other.pth"
    torch.save({"speed": torch.tensor(1.0)}, other)
    with pytest.raises(UserError, match="cannot be loaded.*confidence"):
        make_tracker(checkout, weights=str(other))
    other.write_bytes(b"\x80\x04cos\nsystem\n(Vecho\ntR.")  # a pickle that runs a command
    with pytest.raises(UserError, match="cannot be loaded"):
        make_tracker(checkout, weights=str(other))
