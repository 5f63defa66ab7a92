"""Regions of a part's shape, and rotations about a joint."""

import numpy as np
import pytest

from physagent_jax.forces.regions import grade_part, make_region_mask
from physagent_jax.forces.schema import Bend, CellsRegion, ForceField
from tests.forces.test_skills import DURATION, FRAME_DT, SCALING, moved


def test_cells_hold_what_is_nearest_to_their_seeds():
    """In metres: fractions of a flat box would call other seeds the nearest."""
    chance = np.random.default_rng(0)
    rest = chance.uniform(0, 1, (500, 3)) * (4.0, 1.0, 0.5) + (3, -2, 7)
    low, size = rest.min(0), np.ptp(rest, axis=0)
    inside, outside = chance.uniform(0, 1, (5, 3)), chance.uniform(0, 1, (9, 3))
    region = CellsRegion(inside=tuple(map(tuple, inside)), outside=tuple(map(tuple, outside)))
    distance = [np.linalg.norm(rest[:, None] - (low + s * size), axis=2).min(1) for s in (inside, outside)]
    assert (make_region_mask(region, rest) == (distance[0] < distance[1])).all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_part_turns_about_its_joint(x64, sign):
    """Its particles follow the circles about the pivot, and stay where they were brought."""
    turn = dict(
        constraint_type="enforce_particle_rotation",
        vector=[0, 0, 1],
        magnitude=sign * 0.8,
        gain=1.5,
        active_time=[0, 8],
        held_until=19,
        region={"kind": "half_space", "point": [0.6, 0.5, 0.5], "normal": [1, 0, 0]},
        pivot=[0.5, 0.5, 0.5],
    )
    field = ForceField.model_validate({"constraints": [turn]})
    _, start, end = moved(field, cells=(8, 3, 3), E=1e5, seconds=0.9 * DURATION, extent=0.4)
    rest, now = np.asarray(start.x), np.asarray(end.x)
    part = make_region_mask(field.constraints[0].region, rest)
    pivot = rest.min(0) + 0.5 * np.ptp(rest, axis=0)
    angle = sign * 0.8 * 1.5 * SCALING.rotation * 8 * FRAME_DT
    c, s = np.cos(angle), np.sin(angle)
    wanted = pivot + (rest[part] - pivot) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(now[part], wanted, atol=2e-3)


def test_a_part_that_is_carried_turns_on_what_moves(x64):
    """Its pivot goes with the mean of the rest, which is pushed, and not through the place where that was."""
    region = {"kind": "half_space", "point": [0.6, 0.5, 0.5], "normal": [1, 0, 0]}
    turn = dict(constraint_type="enforce_particle_rotation", vector=[0, 0, 1], magnitude=0.8, gain=1.5)
    turn |= dict(active_time=[0, 8], held_until=19, region=region, pivot=[0.5, 0.5, 0.5], carried=True)
    push = dict(action_type="translation", vector=[0, 1, 0], magnitude=1.0, active_time=[0, 8])
    field = ForceField.model_validate({"constraints": [turn], "actions": [push]})
    _, start, end = moved(field, cells=(8, 3, 3), E=1e5, seconds=0.9 * DURATION, extent=0.4)
    rest, now = np.asarray(start.x), np.asarray(end.x)
    part = make_region_mask(field.constraints[0].region, rest)
    gone = now[~part].mean(0) - rest[~part].mean(0)
    angle = 0.8 * 1.5 * SCALING.rotation * 8 * FRAME_DT
    c, s = np.cos(angle), np.sin(angle)
    pivot = rest.min(0) + 0.5 * np.ptp(rest, axis=0)
    wanted = pivot + gone + (rest[part] - pivot) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(now[part], wanted, atol=2e-3)
    assert np.linalg.norm(gone) > 0.02


def test_a_part_bends_beside_its_joint():
    """A bar on a block: none of the motion where it begins, all of it beyond the depth, and no step in between."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 3, indexing="ij"), -1).reshape(-1, 3)
    bar = grid * (1.0, 0.2, 0.2) + (1.0, 0.4, 0.4)
    rest = np.concatenate([grid, bar[bar[:, 0] > 1.01]])
    region = CellsRegion(inside=((0.49, 0.5, 0.5),), outside=((0.53, 0.5, 0.5),))
    bend = Bend(joint=(0.5, 0.5, 0.5), rest=region, reach=0.1, depth=0.2)
    part, share, middle = grade_part(bend, rest)
    along = rest[part, 0] - 1.0
    assert (part == (rest[:, 0] > 1.02)).all()
    assert share[along < 0.06].max() < 0.1 and share[along > 0.46].min() == 1.0
    means = np.array([share[np.isclose(along, each)].mean() for each in np.unique(along.round(6))])
    assert (np.diff(means) > -1e-9).all() and np.diff(means).max() < 0.2
    np.testing.assert_allclose(middle, [1.2, 0.5, 0.5], atol=0.06)


def test_a_flat_part_moves_too():
    """A plate on the side of a block: its own thickness is far less than the way that its joint would bend over."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 3, indexing="ij"), -1).reshape(-1, 3)
    region = CellsRegion(inside=((0.42, 0.5, 0.5),), outside=((0.96, 0.5, 0.5),))
    bend = Bend(joint=(0.7, 0.5, 0.5), rest=region, reach=1.0, depth=0.9)
    part, share, _ = grade_part(bend, grid)
    assert share[grid[part, 0] == 1].min() == 1.0


def test_what_is_carried_may_come_before_all_else(x64):
    region = {"kind": "half_space", "point": [0.6, 0.5, 0.5], "normal": [1, 0, 0]}
    turn = dict(constraint_type="enforce_particle_rotation", vector=[0, 0, 1], magnitude=0.6, carried=True)
    fall = dict(action_type="torque", vector=[0, 1, 0], magnitude=1.4, active_time=[10, 16])
    turn |= dict(active_time=[0, 8], region=region, pivot=[0.5, 0.5, 0.5])
    field = ForceField.model_validate({"constraints": [turn], "actions": [fall]})
    _, start, end = moved(field, cells=(8, 3, 3), E=1e5, seconds=DURATION, extent=0.4)
    assert np.abs(np.asarray(end.x) - np.asarray(start.x)).max() > 0.02


@pytest.mark.parametrize("change", [dict(region=None), dict(constraint_type="moving_plate")])
def test_only_a_region_of_particles_is_carried(change):
    region = {"kind": "half_space", "point": [0.6, 0.5, 0.5], "normal": [1, 0, 0]}
    turn = dict(constraint_type="enforce_particle_rotation", vector=[0, 0, 1], region=region, carried=True)
    with pytest.raises(ValueError, match="carried"):
        ForceField.model_validate({"constraints": [turn | change]})
