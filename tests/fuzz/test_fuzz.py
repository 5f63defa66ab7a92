"""Every reader, scene field, option and sentence: accepted and finite, or refused in one line (`tests.fuzz.contract`).

The same seed each time, so that a failure is the same everywhere. More, and other, cases: `python -m tests.fuzz
--help`.
"""

from __future__ import annotations

import pytest

from tests.fuzz.campaign import again
from tests.fuzz.classes import CLASSES
from tests.fuzz.contract import Outcome

SEED = 20261122
CHUNK = 80  # cases of a test
SHOWN = 12  # failures that a test tells of


def _list_chunks():
    for name, each in CLASSES.items():
        for start in range(0, each.usual, CHUNK):
            yield pytest.param(name, range(start, min(start + CHUNK, each.usual)), id=f"{name}-{start}")


def test_there_are_enough_cases():
    assert sum(each.usual for each in CLASSES.values()) >= 3000


@pytest.mark.parametrize(("name", "indices"), list(_list_chunks()))
def test_accepted_and_finite_or_refused_in_one_line(name, indices, examiner):
    results = [(index, *examiner.examine(name, SEED, index)) for index in indices]
    failed = [
        f"{result.fault}: {what[:200]}\n    {result.detail[:300]}\n    at {result.place or '-'}\n"
        f"    {again(name, SEED, index)}"
        for index, what, result in results
        if result.outcome is Outcome.FAILED
    ]
    assert not failed, f"{len(failed)} of {len(indices)} cases failed:\n" + "\n".join(failed[:SHOWN])
    assert {result.outcome for _, _, result in results} <= {Outcome.ACCEPTED, Outcome.REFUSED}


@pytest.mark.parametrize("name", CLASSES)
def test_the_same_number_is_the_same_case(name):
    one, other = (CLASSES[name].case(SEED, 7) for _ in range(2))
    assert one.what == other.what and dict(one.files) == dict(other.files)
    texts = {CLASSES[name].case(SEED, index).what for index in range(20)}
    assert len(texts) > 5
