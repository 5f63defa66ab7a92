"""A simulation that takes too long is given up when that is seen, and not at its end."""

from types import SimpleNamespace

import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.simulation.simulate import check_pace


def frames(*substeps):
    return [SimpleNamespace(index=index, substeps=count) for index, count in enumerate(substeps)]


def test_what_keeps_its_pace_goes_on():
    made = frames(0, *[100] * 20)
    assert list(check_pace(iter(made), 21, 2000)) == made


def test_a_short_burst_is_no_pace():
    made = frames(0, *[20] * 5, 300, *[20] * 14)
    assert list(check_pace(iter(made), 21, 2000)) == made


def test_what_gets_slow_is_given_up_soon():
    seen = []
    with pytest.raises(UserError, match="substeps"):
        for frame in check_pace(iter(frames(0, *[20] * 5, *[400] * 15)), 21, 2000):
            seen.append(frame)
    assert len(seen) < 9
