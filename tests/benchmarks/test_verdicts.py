"""Clips of `benchmarks.verdicts`: enough of every kind, made of scene data; and how verdicts are counted."""

from __future__ import annotations

from collections import Counter
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.verdicts import motions as m
from benchmarks.verdicts.backgrounds import BACKGROUNDS, WALL, compose
from benchmarks.verdicts.catalogue import list_clips
from benchmarks.verdicts.claims import Gone, Seen, Still, find_faults
from benchmarks.verdicts.clip import Wrong
from benchmarks.verdicts.figures import find_excess
from benchmarks.verdicts.judging import make_brief
from benchmarks.verdicts.motions import FRICTION, GRAVITY, Motion
from benchmarks.verdicts.recording import Recording
from benchmarks.verdicts.scenes import make_scene
from benchmarks.verdicts.things import THINGS, list_things, load_body
from physagent_jax.render import look_at


def test_the_catalogue_has_enough_of_everything_without_a_folder_of_data():
    clips = list_clips(None)
    assert len(clips) >= 400 and len({clip.name for clip in clips}) == len(clips)
    assert len(list_things(None)) >= 8 and {clip.thing for clip in clips} == set(list_things(None))
    kinds = Counter(clip.wrong for clip in clips)
    assert set(kinds) == {None, *get_args(Wrong)} and kinds[None] >= 100
    for values in (BACKGROUNDS, ("development", "test"), ("free", "ground")):
        counts = Counter(clip.background for clip in clips) if values is BACKGROUNDS else None
        counts = counts or Counter(clip.half if "test" in values else clip.world for clip in clips)
        assert min(counts[value] for value in values) >= 0.15 * len(clips)


def test_a_sentence_has_right_and_wrong_motions_and_one_world():
    clips = list_clips(None)
    for told in {(clip.thing, clip.name.split("/")[1]) for clip in clips}:
        mine = [clip for clip in clips if (clip.thing, clip.name.split("/")[1]) == told]
        assert len({(clip.sentence, clip.world, clip.held) for clip in mine}) == 1
        assert any(clip.wrong is None for clip in mine) and any(clip.wrong for clip in mine)
        assert make_brief(mine[0]).world == mine[0].world


@pytest.mark.parametrize("shift", [0.05, 0.7, 3.0])
def test_shifts_are_what_they_are_called(shift):
    """A point under a motion's causes, and on the ground under friction."""
    step = 1e-4
    for parts, brake in ((m.glide(m.LEFT, shift), 0.0), (m.slide(m.LEFT, shift), FRICTION * GRAVITY)):
        speed = place = 0.0
        for t in np.arange(0.0, 6.0, step):
            active = [c for c in parts if isinstance(c, m.Push | m.Tow) and c.start <= t < c.end]
            pushed = sum(
                -c.direction[0] * c.strength
                if isinstance(c, m.Push)
                else m.TOWED * (-c.direction[0] * c.speed - speed)
                for c in active
            )
            speed += step * (pushed - (brake if speed > 0 or pushed > 0 else 0.0))
            speed = max(speed, 0.0) if brake else speed
            place += step * speed
        assert place == pytest.approx(shift, rel=2e-2, abs=1e-3)


TIMES = np.linspace(0, 1, 26)


def _see(x: np.ndarray, covered: float = 100.0) -> Seen:
    """Particles of a cube of 1 L at every instant, ``x`` (T, n, 3); at the end ``covered`` of 100 pixels show them."""
    return Seen(x, np.linspace(100.0, covered, len(x)), 0.04)


def _fill() -> np.ndarray:
    side = np.linspace(-0.5, 0.5, 11)
    return np.stack(np.meshgrid(side, side, side), -1).reshape(-1, 3)


def _turned(x: np.ndarray, axis, degrees: np.ndarray) -> np.ndarray:
    """About a world axis, in the viewer's left-handed coordinates."""
    turns = Rotation.from_rotvec(-np.radians(degrees)[:, None] * np.asarray(axis))
    return np.stack([turn.apply(x) for turn in turns])


CUBE = _fill()
MOVES = CUBE + TIMES[:, None, None] * np.array([-0.7, 0, 0])
TWISTED = np.where(CUBE[:, 1:2] > 0, _turned(CUBE, m.UP, 35 * TIMES), _turned(CUBE, m.UP, -35 * TIMES))
TORN = CUBE + TIMES[:, None, None] * np.where(CUBE[:, :1] > 0.2, 0.5, 0.0) * np.array([1.0, 0, 0])


@pytest.mark.parametrize(
    ("x", "true", "untrue"),
    [
        (MOVES, m.claim_shift(m.LEFT, 0.7), m.claim_shift(m.LEFT, 0.4)),
        (MOVES, m.claim_shift(m.LEFT, 0.35, 0.0, 0.5), m.claim_shift(m.RIGHT, 0.35, 0.0, 0.5)),
        (MOVES, m.claim_shift(m.turned(m.LEFT, 5), 0.7), m.claim_shift(m.turned(m.LEFT, 40), 0.6)),
        (MOVES, m.Reach(m.LEFT, 0.6), m.Reach(m.LEFT, 0.6, back=0.5)),
        (_turned(CUBE, m.UP, 120 * TIMES), m.claim_turn(m.UP, 120), m.claim_turn(m.DOWN, 120)),
        (_turned(CUBE, m.UP, 120 * TIMES), m.claim_turn(m.UP, 110), m.claim_turn(m.turned(m.UP, 60), 60)),
        (TWISTED, m.twist(m.UP, 70)[-1], m.twist(m.DOWN, 70)[-1]),
        (
            CUBE * (1 - 0.5 * TIMES[:, None, None] * [0, 1, 0]),
            m.Resize(m.UP, -0.55, -0.45),
            m.Resize(m.UP, 0.4, 0.5),
        ),
        (np.repeat(CUBE[None], 26, 0), Still(), m.claim_shift(m.LEFT, 0.5)),
        (CUBE * (1 + 3 * TIMES[:, None, None]), m.Broken(), Gone()),
    ],
)
def test_claims_tell_a_motion_from_another(x, true, untrue):
    assert find_faults([true], _see(x)) == []
    assert len(find_faults([untrue], _see(x))) == 1


def test_what_nobody_says_is_a_fault():
    assert "moves by 0.70 L, which nobody says" in find_faults([m.Resize(m.UP, -0.1, 0.1)], _see(MOVES))[0]
    leaning = _turned(CUBE, m.AWAY, 60 * TIMES)
    assert "turns by 60 degrees, which nobody says" in find_faults([], _see(leaning))[0]
    assert find_faults([], _see(leaning), tips=True) == []
    assert "2 pieces" in find_faults([m.Shift(m.RIGHT, 0.0, 1.0)], _see(TORN))[0]
    assert find_faults([Gone()], _see(MOVES, covered=2.0)) == []


def test_every_motion_says_what_comes_of_it():
    assert all(clip.motion.claims for clip in list_clips(None))


def test_turning_a_direction():
    np.testing.assert_allclose(m.turned(m.LEFT, 90), (0, -1, 0), atol=1e-6)
    assert np.dot(m.turned(m.LEFT, 60, m.UP), m.LEFT) == pytest.approx(0.5)


def test_a_scene_follows_the_camera_and_keeps_its_program(tmp_path):
    source, body = load_body("crate", tmp_path, None)
    thing = THINGS["crate"]
    pushed = make_scene(thing, source, body, Motion("", m.glide(m.RIGHT, 0.7)))
    angle = np.radians(thing.azimuth)
    np.testing.assert_allclose(
        np.divide(pushed.forces[0].acceleration, 0.7), (np.cos(angle), np.sin(angle), 0), atol=1e-6
    )
    still = make_scene(thing, source, body, Motion(""))
    assert [type(force) for force in still.forces] == [type(force) for force in pushed.forces]
    assert len(still.force_field.actions) == len(pushed.force_field.actions)
    with pytest.raises(ValueError, match="factor of 4"):
        spins = (*m.turn(m.UP, 10), *m.turn(m.UP, 100))
        make_scene(thing, source, body, Motion("", spins))


def test_what_stands_behind_has_depth_and_is_covered_by_the_object():
    camera = look_at((0, -4, 1), (0, 0, 0.5), (0, 0, 1), fov_degrees=40, width=32, height=24)
    alpha = np.zeros((1, 24, 32), np.uint8)
    alpha[0, 8:16, 10:20] = 255
    clip = Recording(
        particles=np.zeros((1, 1, 3), np.float32),
        gaussians=np.zeros((1, 1, 3), np.float32),
        rgb=np.where(alpha[..., None] > 0, [200, 10, 10], 0).astype(np.uint8),
        alpha=alpha,
        depth=np.where(alpha > 0, 4.0, 0.0).astype(np.float32),
        camera=camera,
        ground=0.0,
        middle=np.array([0, 0, 0.5]),
    )
    for background in BACKGROUNDS:
        rgb, depth = compose(clip, background, None)
        np.testing.assert_array_equal(rgb[alpha > 0], np.tile([200, 10, 10], (80, 1)))
        np.testing.assert_allclose(depth[alpha > 0], 4.0)
        behind = depth[alpha == 0]
        if background == "plain":
            assert not behind.any()
            continue
        assert np.isfinite(behind).all() and behind.min() > 0
        assert behind.max() == pytest.approx(4 + WALL, rel=0.3)
        assert rgb[alpha == 0].std() > 10  # it has texture


def test_more_false_verdicts_than_allowed_are_found():
    def rows(label: str, right: int, false: int) -> list[dict]:
        return [{"label": label, "right": index < right} for index in range(right + false)]

    few = {"truth": {"rows": rows("FAIL", 99, 1) + rows("SUCCESS", 19, 1)}}
    assert find_excess(few) == []
    many = {"pictures": {"rows": rows("FAIL", 90, 10) + rows("SUCCESS", 80, 20)}}
    assert len(find_excess(many)) == 2 and "false SUCCESS (10.0 %)" in find_excess(many)[0]
