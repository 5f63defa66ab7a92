"""Sides that stand behind a part are put before it."""

import pytest

from physagent_jax.run.sides import put_sides_first


@pytest.mark.parametrize(
    ("told", "read"),
    [
        ("the ear on the left bends", "the leftmost ear bends"),
        ("raise its arms on the right hand side", "raise its rightmost arms"),
        ("the wheel at the front falls off", "the front wheel falls off"),
        ("the end that sticks out on the right bends", "the right protrusion bends"),
        ("both wheels on the left side come off", "both left wheels come off"),
        ("hit the robot on the left side", "hit the robot on the left side"),
        ("the ear on the left side of its head bends", "the ear on the left side of its head bends"),
        ("the face on the left melts", "the face on the left melts"),
    ],
)
def test_a_side_behind_a_part_is_put_before_it(told, read):
    assert put_sides_first(told) == read
