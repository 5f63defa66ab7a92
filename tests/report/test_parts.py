"""The page's parts by themselves: numbers, directions, highlights, ticks."""

from __future__ import annotations

import re

import pytest

from physagent_jax.agents.schema import Evidence
from physagent_jax.forces.schema import BoxRegion, HalfSpaceRegion, SphereRegion
from physagent_jax.report.directions import (
    describe_axis,
    describe_direction,
    describe_turn,
    label_world_axes,
    make_direction_table,
)
from physagent_jax.report.force_cards import describe_region
from physagent_jax.report.formats import (
    format_fixed,
    format_number,
    format_percent,
    format_quantity,
    format_seconds,
    format_vector,
)
from physagent_jax.report.markup import escape, join, raw, tag
from physagent_jax.report.plot import Plot, Series, choose_step, draw, place_ticks
from physagent_jax.report.words import find_highlights
from physagent_jax.scene.config import CameraConfig

FRONT = make_direction_table(CameraConfig())
FROM_PLUS_X = make_direction_table(CameraConfig(azimuth_degrees=90))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (format_number(0.0), "0"),
        (format_number(1234.5), "1234"),
        (format_number(-0.25), "\u22120.25"),
        (format_number(1.2345e-7), "1.23 \u00d7 10\u207b\u2077"),
        (format_number(9.999), "10"),
        (format_fixed(-0.001), "0.00"),
        (format_vector((-1, 0, 0.5)), "(\u22121.00, 0.00, 0.50)"),
        (format_quantity(1e5, "Pa"), "100 kPa"),
        (format_quantity(2e6, "Pa"), "2 MPa"),
        (format_quantity(5e-4, "s"), "500 \u00b5s"),
        (format_quantity(0.0, "J"), "0 J"),
        (format_seconds(75.4), "1 min 15 s"),
        (format_seconds(0.012), "12 ms"),
        (format_percent(0.48), "48 %"),
        (format_percent(0.0131), "1.3 %"),
        (format_percent(None), "\u2014"),
    ],
)
def test_numbers_for_people(text, expected):
    assert text == expected


def test_directions_follow_the_camera():
    assert describe_direction((-1, 0, 0), FRONT) == "left"
    assert describe_direction((0, -1, 0), FRONT) == "towards us"
    assert describe_direction((0, 1, 0), FROM_PLUS_X) == "right"
    assert describe_direction((1, 0, 0), FROM_PLUS_X) == "towards us"
    assert describe_direction((0.9, 0, -0.43), FRONT) == "right and slightly down"
    assert describe_axis((0, 0, -1), FRONT) == "the vertical axis"
    assert label_world_axes(FRONT) == ("x (right)", "y (away from us)", "z (up)")


def test_turns_follow_the_right_hand_rule():
    assert describe_turn((0, 0, 1), FRONT) == "counter-clockwise seen from above"
    # About the axis towards us, x (right) turns to z (up).
    assert describe_turn((0, -1, 0), FRONT) == "counter-clockwise as we see it"
    # About x (right), z (up) turns to -y (towards us).
    assert describe_turn((1, 0, 0), FRONT) == "the top tips towards us"


def test_regions_in_words():
    assert describe_region(None) == "the whole object"
    assert describe_region(BoxRegion(low=(0, 0, 0), high=(1, 1, 0.3))) == "the lower 30 % along z"
    assert describe_region(BoxRegion(low=(0, 0, 0.2), high=(1, 1, 0.3))) == "20\u201330 % along z"
    assert describe_region(BoxRegion(low=(0, 0.1, 0.2), high=(1, 1, 1))).startswith("a box from")
    assert "towards (1.00, 0.00, 0.00)" in describe_region(
        HalfSpaceRegion(point=(0.5, 0.5, 0.5), normal=(2, 0, 0))
    )
    assert "radius 0.2 body lengths" in describe_region(SphereRegion(center=(0, 0, 1), radius=0.2))


def evidence(*words: str) -> list[Evidence]:
    return [Evidence(words=each, field="actions[0].vector", value="", why="") for each in words]


def test_highlights_take_whole_words_and_the_longest_phrase():
    prompt = "Leftover wind blows Left, to  the left"
    placed = find_highlights(prompt, evidence("left", "to the left"), ["blows"])
    assert [(prompt[h.start : h.end], h.rows) for h in placed] == [
        ("blows", ()),
        ("Left", (0,)),
        ("to  the left", (1,)),
    ]


def test_highlights_that_overlap_share_a_mark():
    prompt = "blow it to the left"
    (only,) = find_highlights(prompt, evidence("to the left", "left", "absent"), [])
    assert (prompt[only.start : only.end], only.rows) == ("to the left", (0, 1))


@pytest.mark.parametrize(("low", "high"), [(0, 1), (-0.33, 0.21), (1e-7, 3e-7), (0.95, 1.05), (-4e5, 9e6)])
def test_ticks_are_round_and_few(low, high):
    step = choose_step(low, high)
    marks = place_ticks(low, high, step)
    assert 2 <= len(marks) <= 8
    assert all(low - 1e-9 * step <= mark <= high + 1e-9 * step for mark in marks)


def test_plots_break_lines_at_gaps():
    picture = draw(Plot("t", "m", 4, [Series("a", [0.0, 1.0, None, 2.0, 3.0])]))
    (path,) = [part for part in picture.split("<path")[1:] if "curve" in part]
    assert path.count("M") == 2 and path.count("L") == 2


def test_plots_of_nothing_and_of_constants_are_drawn():
    for values in ([None, None], [0.0, 0.0], [1e9, 1e9], [1e-12, 1e-12]):
        assert "<svg" in draw(Plot("t", "m", 1, [Series("a", values)]))


@pytest.mark.parametrize(
    "values", [[0.0, -2.5e-4], [3e7, 9e7], [1e-9, 2e-9], [1.0, 1.0000001], [1e300, -1e300]]
)
def test_labels_of_an_axis_fit_beside_it(values):
    picture = draw(Plot("t", "m", 1, [Series("a", values)]))
    left = int(re.search(r'data-left="(\d+)"', picture)[1])
    labels = [m for m in re.findall(r'text-anchor="end">([^<]*)<', picture)]
    assert labels and all(10 * len(label) <= left - 7 for label in labels) and left < 150
    powers = {-2.5e-4: "[10\u207b\u2074 m]", 9e7: "[10\u2077 m]"}
    assert powers.get(values[1], "m]") in picture


def test_markup_escapes_everything_but_markup():
    assert tag("p", "<&>", tag("b", 1), None, ['"'], class_='a"b', data_x=None, hidden=True) == (
        '<p class="a&quot;b" hidden>&lt;&amp;&gt;<b>1</b>&quot;</p>'
    )
    assert join(raw("<i>"), escape("<i>")) == "<i>&lt;i&gt;"
