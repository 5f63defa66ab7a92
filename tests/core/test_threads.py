"""Results made ahead of whoever waits for them."""

import threading

import pytest

from physagent_jax.core.threads import map_ahead


def test_results_come_in_order_and_only_a_few_are_made_ahead():
    begun, release = [], threading.Event()

    def square(number):
        begun.append(number)
        assert number < 3 or release.wait(240)
        return number * number

    results = map_ahead(square, iter(range(10)), 2)
    assert next(results) == 0 and begun == [0]
    assert next(results) == 1
    assert max(begun) <= 3
    release.set()
    assert list(results) == [number * number for number in range(2, 10)]
    assert sorted(begun) == list(range(10))


@pytest.mark.parametrize("bad", [0, 3])
def test_an_error_arrives_where_its_result_would_have(bad):
    results = map_ahead(lambda number: 1 / (number - bad), range(6), 2)
    for number in range(bad):
        assert next(results) == 1 / (number - bad)
    with pytest.raises(ZeroDivisionError):
        next(results)


def test_nothing_of_nothing():
    assert list(map_ahead(abs, [], 2)) == []
