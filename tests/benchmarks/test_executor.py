"""The scenes in which the executor's rewrites are measured."""

import pytest

from benchmarks.executor.scenes import MADE, prepare


@pytest.mark.parametrize("world", ["free", "ground"])
def test_an_object_stands_free_with_the_stiffness_that_is_told(world):
    setting = prepare(next(iter(MADE)), world)
    assert setting.template.anchor.kind == "none" and setting.brief.anchored is None
    assert setting.brief.world == world and setting.template.bearing is None
