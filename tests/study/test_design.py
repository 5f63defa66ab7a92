"""Sheets: every item once, blind places, and balance."""

import itertools

import pytest

from physagent_jax.study.design import make_sheets


def test_three_methods_of_nine_items_as_in_the_paper():
    """Each participant sees each method three times in each place; all three orders of the design are balanced."""
    sheets, balance = make_sheets([("a", "b", "c")] * 9, 3, sheets=20, sets=9, seed=0)
    for sheet in sheets:
        assert sorted(item for item, _ in sheet) == list(range(9))
        for method, place in itertools.product("abc", range(3)):
            assert 2 <= sum(shown[place] == method for _, shown in sheet) <= 4
    assert balance.shown == balance.pairs == (180, 180)
    assert 58 <= balance.places[0] and balance.places[1] <= 62
    assert len({tuple(sheet) for sheet in sheets}) == 20
    assert sheets != make_sheets([("a", "b", "c")] * 9, 3, sheets=20, sets=9, seed=1)[0]
    assert sheets == make_sheets([("a", "b", "c")] * 9, 3, sheets=20, sets=9, seed=0)[0]


@pytest.mark.parametrize("count", [4, 6, 9])
def test_more_methods_than_alternatives_are_balanced_too(count):
    methods = tuple("abcdefghi"[:count])
    sheets, balance = make_sheets([methods] * 8, 3, sheets=30, sets=8, seed=0)
    assert balance.shown[1] - balance.shown[0] <= 2
    assert balance.pairs[1] <= 1.2 * balance.pairs[0] + 2
    assert balance.places[1] - balance.places[0] <= 3
    assert all(len(set(shown)) == 3 for sheet in sheets for _, shown in sheet)


def test_items_that_lack_a_method_and_fewer_sets_than_items():
    items = [("a", "b", "c", "d"), ("a", "b", "c"), ("b", "c", "d"), ("a", "c", "d"), ("a", "b", "d")]
    sheets, balance = make_sheets(items, 3, sheets=40, sets=2, seed=3)
    seen = [item for sheet in sheets for item, shown in sheet if set(shown) <= set(items[item])]
    assert len(seen) == 80 and {seen.count(item) for item in range(5)} == {16}
    assert all(len({item for item, _ in sheet}) == 2 for sheet in sheets)
    assert balance.shown[1] - balance.shown[0] <= 6
