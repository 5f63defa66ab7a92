"""Regression floor of the reading of sentences: shares of the whole corpus that are right and silently wrong."""

import pytest

from benchmarks.language.__main__ import read_one
from benchmarks.language.notation import AUTHORS, read_split
from benchmarks.language.totals import REQUIRED, count_outcomes, describe_shares, is_met


@pytest.mark.parametrize("split", REQUIRED)
def test_enough_of_the_corpus_is_right_and_little_silently_wrong(split):
    """No sentence is told: those of the test split are held back."""
    rows = [read_one(sentence) for sentence in read_split(split)]
    counts = {author: count_outcomes(row for row in rows if row["author"] == author) for author in AUTHORS}
    told = [f"{author}: {describe_shares(count)}" for author, count in counts.items() if count]
    count = count_outcomes(rows)
    assert is_met(split, count), "\n".join([f"{split}: {describe_shares(count)}", *told])
