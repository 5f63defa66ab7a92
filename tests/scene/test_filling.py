import dataclasses
import time
import tracemalloc

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats import read_ply
from physagent_jax.scene.config import Domain, Filling, Source
from physagent_jax.scene.density import CellGrid, overlap_density
from physagent_jax.scene.filling import fill, select_evenly
from physagent_jax.scene.mesh import gaussians_from_mesh
from physagent_jax.scene.placement import place
from physagent_jax.scene.procedural import make_plant
from tests.scene.clouds import box_shell, cloud_of, sphere_shell

FREE = 10_000_000  # no cap
SPOT_VOLUME = 0.718259  # signed volume of the mesh, in its units


def count_filled(particles) -> int:
    """The number of particles that are no Gaussian's centre."""
    return int((particles.gaussian_index < 0).sum())


def test_density_of_one_gaussian_is_its_formula():
    cloud = dataclasses.replace(cloud_of([[0.0, 0, 0]], opacity=0.7), scales=np.float32([[0.2, 0.15, 0.1]]))
    grid = CellGrid(np.full(3, -1.05), 0.1, (21, 21, 21))  # cell (10, 10, 10) is centred on it
    density = overlap_density(cloud, grid)
    assert density[10, 10, 10] == pytest.approx(0.7, rel=1e-6)
    assert density[12, 11, 10] == pytest.approx(0.7 * np.exp(-0.5 * (1.0**2 + (0.1 / 0.15) ** 2)), rel=1e-5)
    assert density[10, 10, 13] == 0  # beyond two standard deviations


@pytest.mark.parametrize("size", [(1.0, 1.0, 1.0), (1.0, 0.6, 0.4)])
@pytest.mark.parametrize("cells", [20, 33, 48])
def test_volumes_of_a_filled_box_sum_to_its_volume(size, cells):
    particles = fill(box_shell(size, 8000), Filling(cells=cells, max_particles=FREE), dx=0.1)
    # A wall cell counts half, so that a face is placed to 0.3 cells at worst.
    worst = 2 * 0.3 / cells * sum(1 / s for s in size)
    assert particles.volume.sum() == pytest.approx(np.prod(size), rel=worst)
    if size == (1.0, 1.0, 1.0):
        assert particles.volume.sum() == pytest.approx(1.0, rel=0.02)
    assert particles.volume.min() > 0


def test_volumes_survive_the_cap():
    cloud = box_shell((1, 1, 1), 8000)
    whole = fill(cloud, Filling(cells=40, max_particles=FREE), dx=0.1)
    for cap in (20_000, 3_000, 300):
        particles = fill(cloud, Filling(cells=40, max_particles=cap), dx=0.1)
        assert particles.count == cap
        assert particles.volume.sum() == pytest.approx(whole.volume.sum(), rel=1e-4)
        assert particles.volume.max() < 40 * particles.volume.sum() / cap  # none stands for a whole region


def test_filling_takes_forty_bytes_a_cell(monkeypatch):
    """So that as many cells as are accepted fit into a laptop's memory; working arrays beside are of fixed size."""
    monkeypatch.setattr("physagent_jax.scene.density._BATCH", 50_000)
    monkeypatch.setattr("physagent_jax.scene.filling._AT_ONCE", 50_000)
    cloud, config = box_shell((1, 1, 1), 40_000), Filling(cells=96, particles_per_cell=4, max_particles=1000)
    tracemalloc.start()
    try:
        fill(cloud, config, dx=0.1)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 40 * 101**3 + 20e6


def test_a_sphere_is_filled_uniformly():
    particles = fill(sphere_shell(0.5, 6000), Filling(cells=40, max_particles=FREE), dx=0.1)
    assert particles.volume.sum() == pytest.approx(4 / 3 * np.pi * 0.5**3, rel=0.03)
    radius = np.linalg.norm(particles.x, axis=1)
    h = 1 / 40
    assert radius.max() < 0.5 + h
    # Half of a ball's volume lies within 2^(-1/3) of its radius.
    inner = particles.volume[radius < 0.5 * 0.5 ** (1 / 3)].sum()
    assert inner == pytest.approx(0.5 * particles.volume.sum(), rel=0.04)


def test_holes_in_the_shell_are_bridged():
    # 3 % of the sphere is missing at +y, one of the directions that must hit a wall.
    particles = fill(sphere_shell(0.5, 6000, opening=0.03), Filling(cells=40, max_particles=FREE), dx=0.1)
    assert 0.75 < particles.volume.sum() / (4 / 3 * np.pi * 0.5**3) < 1.05


def test_an_open_cup_stays_empty_and_a_dome_without_floor_is_filled():
    inside = Filling(cells=30, max_particles=FREE)
    cup = fill(box_shell((1, 1, 1), 8000, skip=(4,)), inside, dx=0.1)
    assert not (np.abs(cup.x) < 0.4).all(axis=1).any()
    dome = box_shell((1, 1, 1), 8000, skip=(5,))
    assert (np.abs(fill(dome, inside, dx=0.1).x) < 0.4).all(axis=1).sum() > 0.9 * 24**3
    closed_only = changed(inside, exclude_direction=None)
    assert not (np.abs(fill(dome, closed_only, dx=0.1).x) < 0.4).all(axis=1).any()


def changed(config, **changes):
    return Filling.model_validate(config.model_dump() | changes)


def test_the_result_does_not_depend_on_how_densely_the_surface_was_sampled():
    volumes = [
        fill(sphere_shell(0.5, n), Filling(cells=30, max_particles=FREE), dx=0.1).volume.sum()
        for n in (3000, 12_000, 48_000)
    ]
    np.testing.assert_allclose(volumes, volumes[0], rtol=0.03)


def test_the_overlap_unit_does_depend_on_it_as_in_physgaussian():
    cloud = sphere_shell(0.5, 3000)
    options = dict(cells=60, max_particles=FREE)
    coverage = fill(cloud, Filling(**options), dx=0.1)
    overlap = fill(cloud, Filling(**options, density_unit="overlap"), dx=0.1)
    assert coverage.volume.sum() == pytest.approx(4 / 3 * np.pi * 0.5**3, rel=0.04)
    assert overlap.volume.sum() < 0.5 * coverage.volume.sum()  # 0.5 Gaussians per cell never add up to 5


def test_same_seed_same_bytes_other_seed_other_places():
    cloud = sphere_shell(0.5, 3000)
    first, again, other = (
        fill(cloud, Filling(cells=24, seed=s, particles_per_cell=2), dx=0.1) for s in (1, 1, 2)
    )
    for name in ("x", "volume", "gaussian_index"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes()
    filled = first.gaussian_index < 0
    assert (first.x[filled] != other.x[filled]).any(axis=1).mean() > 0.99


def test_gaussians_are_particles_and_filled_ones_are_marked():
    cloud = sphere_shell(0.5, 3000)
    particles = fill(cloud, Filling(cells=24), dx=0.1)
    own = particles.gaussian_index >= 0
    np.testing.assert_array_equal(particles.gaussian_index[own], np.arange(3000))
    np.testing.assert_array_equal(particles.x[own], cloud.means)
    assert count_filled(particles) == (~own).sum() > 2000
    shell = fill(cloud, Filling(cells=24, enabled=False), dx=0.1)
    assert count_filled(shell) == 0 and shell.count == 3000


@pytest.mark.parametrize("per_cell", [1, 3, 8])
def test_particles_per_cell_are_met_and_stratified(per_cell):
    particles = fill(
        box_shell((1, 1, 1), 8000), Filling(cells=20, particles_per_cell=per_cell, max_particles=FREE), dx=0.1
    )
    deep = particles.x[(np.abs(particles.x) < 0.4).all(axis=1)]
    assert len(deep) == pytest.approx(per_cell * 16**3, rel=0.08)
    spacing = 0.05 / np.ceil(per_cell ** (1 / 3))
    nearest = np.linalg.norm(deep[:50, None] - deep[None], axis=-1)
    nearest[nearest == 0] = np.inf
    assert nearest.min() > 0.25 * spacing  # jittered, but never on top of each other


def test_the_cap_holds_and_the_inside_keeps_its_share():
    cloud = sphere_shell(0.5, 20_000)
    particles = fill(cloud, Filling(cells=40, max_particles=10_000), dx=0.1)
    assert particles.count == 10_000
    assert count_filled(particles) == 5_000
    few = fill(cloud, Filling(cells=10, max_particles=10_000), dx=0.1)  # the inside needs less than half
    assert few.count == 10_000 and count_filled(few) < 1_000


def test_an_even_subset_is_even_in_space_not_in_count():
    rng = np.random.default_rng(0)
    # Half of the box is sampled 50 times as densely as the other.
    dense = rng.uniform([0, 0, 0], [10, 20, 20], (50_000, 3))
    sparse = rng.uniform([10, 0, 0], [20, 20, 20], (3000, 3))
    cells = np.concatenate([dense, sparse]).astype(int)
    kept = select_evenly(cells, 4000)
    assert len(kept) == len(set(kept.tolist())) == 4000
    occupied_sparse = len(np.unique(cells[50_000:], axis=0))
    left = (kept < 50_000).sum()
    assert left / 4000 == pytest.approx(4000 / (4000 + occupied_sparse), abs=0.05)
    quarters = np.bincount(2 * (cells[kept, 1] // 10) + cells[kept, 2] // 10)
    assert quarters.max() < 1.1 * quarters.min()


@pytest.mark.parametrize("scale", [0.0, 1e9, np.inf])
def test_degenerate_covariances_neither_hang_nor_break_it(scale):
    cloud = sphere_shell(0.5, 3000)
    scales = np.array(cloud.scales)
    scales[::10] = scale
    start = time.process_time()  # of which other programs take none
    particles = fill(dataclasses.replace(cloud, scales=scales), Filling(cells=40), dx=0.1)
    assert time.process_time() - start < 20
    assert np.isfinite(particles.x).all() and np.isfinite(particles.volume).all()
    if scale == 0.0:
        assert particles.volume.sum() == pytest.approx(4 / 3 * np.pi * 0.5**3, rel=0.05)


def test_many_runaway_gaussians_stay_within_the_budget():
    cloud = sphere_shell(0.5, 30_000)
    cloud = dataclasses.replace(cloud, scales=np.full((30_000, 3), 1e9, np.float32))
    start = time.process_time()
    fill(cloud, Filling(cells=64), dx=0.1)
    assert time.process_time() - start < 60


def test_physgaussians_volumes_are_those_of_the_touched_cells():
    cloud = cloud_of([[0.05, 0.05, 0.05], [0.06, 0.05, 0.05], [0.25, 0.05, 0.05]])
    particles = fill(cloud, Filling(enabled=False, volumes="cells"), dx=0.1)
    np.testing.assert_allclose(particles.volume, [0.0005, 0.0005, 0.001], rtol=1e-6)


def test_smoothing_closes_pores():
    rng = np.random.default_rng(0)
    cloud = box_shell((1, 1, 1), 8000)
    keep = np.flatnonzero(rng.uniform(size=cloud.count) < 0.45)
    porous = type(cloud)(*(np.asarray(getattr(cloud, f.name))[keep] for f in dataclasses.fields(cloud)))
    options = dict(cells=40, max_particles=FREE)
    rough = fill(porous, Filling(**options), dx=0.1).volume.sum()
    smooth = fill(
        porous, Filling(**options, density_threshold=2.0, search_threshold=1.5, smooth=True), dx=0.1
    ).volume.sum()
    assert abs(smooth - 1) < min(abs(rough - 1), 0.1)


def test_no_finite_centres_is_an_error():
    with pytest.raises(UserError, match="finite"):
        fill(cloud_of([[0, 0, np.nan], [1, 1, 1]]), Filling(), dx=0.1)
    with pytest.raises(UserError, match="share one centre"):
        fill(cloud_of([[1, 1, 1], [1, 1, 1]]), Filling(), dx=0.1)


def test_the_robot_becomes_a_solid_body(robot_path):
    domain = Domain()
    cloud, _ = place(read_ply(robot_path, opacity_threshold=0.02), Source(path="", up="-y"), domain)
    particles = fill(cloud, Filling(), dx=domain.dx)
    shell = fill(cloud, Filling(enabled=False), dx=domain.dx)
    assert count_filled(particles) > 4000
    assert particles.volume.sum() > 1.5 * shell.volume.sum()
    hull = trimesh.convex.convex_hull(np.asarray(cloud.means)).volume
    assert 0.15 * hull < particles.volume.sum() < hull


def test_a_canopy_is_not_taken_for_a_solid():
    cloud = make_plant(0)
    particles = fill(cloud, Filling(cells=48, max_particles=FREE), dx=1 / 24)
    canopy = particles.x[:, 2] > 0.75
    means = np.asarray(cloud.means)
    hull = trimesh.convex.convex_hull(means[means[:, 2] > 0.75]).volume
    assert particles.volume[canopy].sum() < 0.35 * hull
    pot = particles.x[:, 2] < 0.27
    # A frustum, closed by the soil: radii 0.115 and 0.165 m over 0.225 m, a cylinder of 0.165 m above it,
    # in a plant that `make_plant` then scales to 1 m (by about 1 %).
    frustum = np.pi * 0.225 / 3 * (0.115**2 + 0.115 * 0.165 + 0.165**2) + np.pi * 0.165**2 * 0.045
    assert particles.volume[pot].sum() == pytest.approx(frustum, rel=0.2)


@pytest.fixture(scope="module")
def spot(shared_data):
    path = shared_data / "spot.obj"
    return gaussians_from_mesh(path, count=20_000, up="+y"), trimesh.load(path, force="mesh")


@pytest.mark.parametrize(("cells", "tolerance"), [(32, 0.05), (48, 0.03), (80, 0.06)])
def test_the_cow_is_filled_to_its_volume(spot, cells, tolerance):
    particles = fill(spot[0], Filling(cells=cells, max_particles=FREE), dx=0.1)
    assert particles.volume.sum() == pytest.approx(SPOT_VOLUME, rel=tolerance)


def test_no_particle_sticks_out_of_the_cow_by_more_than_a_cell(spot):
    cloud, mesh = spot
    particles = fill(cloud, Filling(cells=48, max_particles=FREE), dx=0.1)
    x = particles.x[particles.gaussian_index < 0].astype(float)
    outside = x[~encloses(mesh.triangles, x)]
    cell = mesh.extents.max() / 48
    # Distance to 200,000 points of the surface bounds the distance to the surface from above, by half a spacing.
    surface = trimesh.sample.sample_surface(mesh, 200_000, seed=0)[0]
    distance = cKDTree(surface).query(outside)[0] if len(outside) else np.zeros(1)
    assert distance.max() < 1.05 * cell
    assert len(outside) < 0.15 * len(x)  # the inside is what was filled


def test_two_hundred_thousand_particles_take_seconds(spot):
    start = time.process_time()
    particles = fill(spot[0], Filling(cells=96, particles_per_cell=2, max_particles=200_000), dx=0.1)
    assert time.process_time() - start < 15
    assert particles.count == 200_000


def encloses(triangles, points):
    """Return whether a closed mesh encloses each point: parity of the crossings of a ray along +z."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    middle = triangles.mean(axis=1)[:, :2]
    reach = np.linalg.norm(triangles[..., :2] - middle[:, None], axis=-1).max()
    near = cKDTree(middle).query_ball_point(points[:, :2], reach)
    point = np.repeat(np.arange(len(points)), [len(n) for n in near])
    triangle = np.concatenate(near).astype(int)
    a, b, c, p = a[triangle], b[triangle], c[triangle], points[point]

    def area(q, r, s):
        return (r[:, 0] - q[:, 0]) * (s[:, 1] - q[:, 1]) - (r[:, 1] - q[:, 1]) * (s[:, 0] - q[:, 0])

    with np.errstate(divide="ignore", invalid="ignore"):  # triangles seen edge-on
        u, v = area(p, b, c) / area(a, b, c), area(p, c, a) / area(a, b, c)
        height = u * a[:, 2] + v * b[:, 2] + (1 - u - v) * c[:, 2]
        crossed = (u > 0) & (v > 0) & (u + v < 1) & (height > p[:, 2])
    return np.bincount(point, crossed, len(points)) % 2 == 1


def test_grids_beyond_memory_are_refused_before_they_are_made(monkeypatch):
    monkeypatch.setattr("physagent_jax.scene.filling.overlap_density", None)  # would fail if called
    with pytest.raises(UserError, match="too many cells.*517 x 517 x 517.*filling.cells"):
        fill(cloud_of(np.array([[0.0, 0, 0], [1, 1, 1]])), Filling(cells=512), dx=0.1)


def test_places_for_particles_are_counted_before_they_are_made(monkeypatch):
    monkeypatch.setattr("physagent_jax.scene.filling.MOST_PLACES", 1000)
    with pytest.raises(UserError, match="particles_per_cell"):
        fill(box_shell((1, 1, 1), 2000), Filling(cells=24, particles_per_cell=64), dx=0.1)
