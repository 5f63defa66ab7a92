"""Statistics of studies against published examples and scipy."""

import itertools
from collections import Counter

import numpy as np
import pytest
from scipy import stats

from physagent_jax.metrics.statistics import estimate_share
from physagent_jax.study.statistics import (
    compute_agreement,
    compute_alpha,
    compute_fleiss_kappa,
    draw_participants,
    fit_strengths,
    is_estimable,
)

# Fleiss 1971, table 1: psychiatric diagnoses of 30 patients by six raters each, counts of five categories.
FLEISS = """00060 03003 01401 00006 03030 20400 00402 20310 20040 00006 10050 11040 03300 10050 02031
00501 30012 51000 02040 10203 00006 01050 02013 20040 10041 05010 40002 02040 10500 00006"""

# Agresti 2002, table 10.10: the American League's Eastern Division of 1987. Row: at home; column: away; wins of both.
GAMES = """-- 43 42 43 61 42 60
33 -- 42 43 60 61 43
25 43 -- 24 43 42 60
33 51 25 -- 43 42 61
51 25 33 42 -- 52 60
25 33 34 43 42 -- 24
25 15 16 24 16 34 --"""


def read_table(text):
    return np.array([[int(digit) for digit in word] for word in text.split()])


def test_kappa_of_fleiss_1971():
    table = read_table(FLEISS)
    assert table.shape == (30, 5) and (table.sum(1) == 6).all()
    assert compute_fleiss_kappa(table) == pytest.approx(0.430, abs=5e-4)
    assert compute_fleiss_kappa(table[:, :3]) is None  # unequal numbers of raters
    assert compute_fleiss_kappa(np.array([[3, 0], [3, 0]])) is None  # one category: chance alone


def test_alpha_of_krippendorff_2011():
    """Section C of "Computing Krippendorff's Alpha-Reliability": four observers, twelve units, with gaps."""
    counts = np.zeros((12, 5), int)
    for row in ("123321412...", "1233224125.3", ".3332342251.", "12332441251."):
        for unit, digit in enumerate(row):
            if digit != ".":
                counts[unit, int(digit) - 1] += 1
    assert compute_alpha(counts) == pytest.approx(0.743, abs=5e-4)
    assert compute_alpha(np.eye(3, dtype=int)) is None and compute_alpha(np.empty((0, 3))) is None
    assert compute_agreement(np.array([[2, 1]])) == pytest.approx(1 / 3)


def test_strengths_of_agresti():
    """Table 10.11 of Agresti 2002: strengths over Baltimore's without the home advantage, errors of about 0.3."""
    choices = Counter()
    for home, line in enumerate(GAMES.splitlines()):
        for away, word in enumerate(line.split()):
            if home != away:
                pair = tuple(sorted((home, away)))
                choices[pair, home] += int(word[0])
                choices[pair, away] += int(word[1])
    strengths, covariance = fit_strengths(choices, 7)
    assert np.round(strengths - strengths[-1], 2).tolist() == [1.58, 1.44, 1.29, 1.25, 1.11, 0.68, 0]
    errors = np.sqrt(np.diag(covariance)[:-1] + covariance[-1, -1] - 2 * covariance[:-1, -1])
    assert np.round(errors, 1).tolist() == [0.3] * 6
    assert abs(strengths.sum()) < 1e-6


def test_strengths_of_choices_among_three_are_found_again():
    true = np.array([0.8, 0.1, -0.2, -0.7])
    rng, choices = np.random.default_rng(0), Counter()
    for shown in itertools.combinations(range(4), 3):
        chances = np.exp(true[list(shown)])
        for place, votes in enumerate(rng.multinomial(4000, chances / chances.sum())):
            choices[shown, shown[place]] += int(votes)
    found, covariance = fit_strengths(choices, 4)
    errors = np.sqrt(np.diag(covariance))
    assert (np.abs(found - true) < 4 * errors).all() and errors.max() < 0.03


def test_what_is_never_chosen_has_no_finite_strength():
    assert not is_estimable({((0, 1, 2), 0): 3, ((0, 1, 2), 1): 2}, 3)  # 2 is never chosen
    assert not is_estimable(
        {((0, 1), 0): 1, ((0, 1), 1): 1, ((2, 3), 2): 1, ((2, 3), 3): 1}, 4
    )  # two islands
    assert is_estimable({((0, 1), 0): 1, ((1, 2), 1): 1, ((0, 2), 2): 1}, 3)  # a circle


@pytest.mark.parametrize(("chosen", "shown"), [(0, 20), (3, 20), (10, 20), (20, 20), (81, 263)])
def test_wilson(chosen, shown):
    """The ends are the shares whose score test just gives 5 %; 81 of 263 is Newcombe's example (1998)."""
    found = estimate_share([1.0] * chosen + [0.0] * (shown - chosen))
    share, low, high = found.value, found.low, found.high
    z = stats.norm.ppf(0.975)
    for end in (low, high):
        if 0 < end < 1:
            assert abs(share - end) == pytest.approx(z * np.sqrt(end * (1 - end) / shown))
    if shown == 263:
        assert (round(low, 4), round(high, 4)) == (0.2553, 0.3662)


def test_participants_of_one_mind_widen_the_interval():
    """Ten people who answer ten times alike are worth ten votes, not a hundred."""
    alike = draw_participants(np.array([10, 0] * 5), np.full(10, 10))
    apart = draw_participants(np.full(10, 5), np.full(10, 10))
    assert alike[1] - alike[0] > 0.5 and apart[1] - apart[0] < 1e-9
    assert draw_participants(np.full(4, 5), np.full(4, 10)) is None
