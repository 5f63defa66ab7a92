import numpy as np
import pytest

from physagent_jax.scene.config import Filling
from physagent_jax.scene.filling import fill
from physagent_jax.scene.procedural import PROCEDURAL, make_loaf, make_plant
from physagent_jax.scene.surfels import SH_DC

SEEDS = (0, 1, 5)


def colours(cloud):
    return np.asarray(cloud.sh)[:, 0] * SH_DC + 0.5


@pytest.fixture(scope="module")
def clouds():
    return {(name, seed): make(seed) for name, make in PROCEDURAL.items() for seed in SEEDS}


@pytest.mark.parametrize("name", PROCEDURAL)
@pytest.mark.parametrize("seed", SEEDS)
def test_objects_stand_on_the_ground_and_are_about_a_metre(clouds, name, seed):
    cloud = clouds[name, seed]
    x = np.asarray(cloud.means)
    assert 3000 <= cloud.count <= 8100
    assert cloud.sh_degree == 0
    assert np.isfinite(x).all() and np.isfinite(cloud.sh).all()
    assert x[:, 2].min() == pytest.approx(0, abs=1e-6)
    assert np.ptp(x, axis=0).max() == pytest.approx(1.0, abs=0.1)
    assert 0.0 <= colours(cloud).min() and colours(cloud).max() <= 1.0


@pytest.mark.parametrize("name", PROCEDURAL)
def test_the_seed_decides(clouds, name):
    again = PROCEDURAL[name](1)
    for field in ("means", "quats", "scales", "sh"):
        np.testing.assert_array_equal(getattr(again, field), getattr(clouds[name, 1], field))
    assert (np.asarray(again.means)[:100] != np.asarray(clouds[name, 5].means)[:100]).any()


@pytest.mark.parametrize("name", PROCEDURAL)
def test_neighbours_differ_enough_for_tracking(clouds, name):
    """Optical flow needs contrast at the scale of a few pixels: 0.03 m is 5 of them in a 320 px picture."""
    cloud = clouds[name, 0]
    x, brightness = np.asarray(cloud.means), colours(cloud).mean(axis=1)
    cell = np.unique(np.floor(x / 0.12), axis=0, return_inverse=True)[1].ravel()
    spread = [brightness[cell == c].std() for c in range(cell.max()) if (cell == c).sum() > 20]
    assert np.median(spread) > 0.03


@pytest.mark.parametrize("seed", SEEDS)
def test_the_trunk_is_thick_enough_to_be_simulated(clouds, seed):
    x = np.asarray(clouds["plant", seed].means)
    # Between the rim and the first branch there is only the trunk; it leans, so slices are thin.
    for low in np.arange(0.34, 0.44, 0.02):
        slab = x[(x[:, 2] > low) & (x[:, 2] < low + 0.02)]
        assert np.ptp(slab[:, :2], axis=0).min() >= 2.5 / 24


@pytest.mark.parametrize(("name", "low", "high"), [("loaf", 0.12, 0.24), ("jelly", 0.3, 0.45)])
def test_solids_fill_to_the_same_volume_at_any_resolution(clouds, name, low, high):
    volumes = [
        fill(clouds[name, 0], Filling(cells=cells, max_particles=10**7), dx=0.1).volume.sum()
        for cells in (32, 48, 64)
    ]
    np.testing.assert_allclose(volumes, np.mean(volumes), rtol=0.05)
    assert low < volumes[-1] < high  # the bounding boxes hold 0.24 and 0.75 m^3


def test_the_count_can_be_chosen():
    assert make_plant(0, count=4000).count == pytest.approx(4000, abs=30)
    assert make_loaf(0, count=3000).count == pytest.approx(3000, abs=30)
