"""The domain's walls, which nobody sees: what is pushed hard stops short of them."""

import numpy as np
import pytest
import trimesh

from physagent_jax.forces.free_path import compute_free_path
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.scene.fuse import fuse
from tests.scene.test_standing import template_of


@pytest.fixture(scope="module")
def plank(tmp_path_factory):
    path = tmp_path_factory.mktemp("plank") / "thing.obj"
    trimesh.creation.box((1.0, 0.4, 0.3)).export(path)
    return template_of(path, overrides={"max_particles": 1000, "cells": 48})


def find_way(plank, kind, magnitude):
    """The free path of a push along the plank, and its scene."""
    template, body, _ = plank
    window = (0, 1) if kind is ActionType.IMPULSE else None
    action = Action(action_type=kind, vector=(1, 0, 0), magnitude=magnitude, active_time=window)
    field = ForceField(actions=(action,))
    scene = fuse(template, body, field)
    timing = scene.timing
    path = compute_free_path(field, scene.scaling, frame_dt=timing.frame_dt, frame_count=timing.frame_count)
    return path[-1], body, scene


@pytest.mark.parametrize("kind", [ActionType.TRANSLATION, ActionType.IMPULSE])
def test_the_hardest_push_stays_inside(plank, kind):
    with pytest.warns(UserWarning, match="as far as asked: the simulated room ends there"):
        way, body, scene = find_way(plank, kind, 1.6)
    assert 1.0 < way[0] and body.high[0] + way[0] < scene.domain.size - 4 * scene.domain.dx
    np.testing.assert_allclose(way[1:], 0, atol=1e-6)


def test_what_has_room_goes_as_far_as_it_is_asked(plank):
    way, body, scene = find_way(plank, ActionType.TRANSLATION, 1.0)
    assert way[0] == pytest.approx(1.02, abs=0.02) and "room" not in scene.scaling.reason
