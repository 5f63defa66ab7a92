"""One small task for all tests here: its programs are compiled once."""

import pytest

from tests.baselines.tiny import TinyTask, act, make_tiny_task

HIDDEN = act("translation", (-0.9, 0.1, 0.4), 1.3)
START = act("translation", (0.3, 0.5, 0.1), 0.8)


@pytest.fixture(scope="session")
def tiny(tmp_path_factory) -> TinyTask:
    return make_tiny_task(tmp_path_factory.mktemp("tiny"), HIDDEN, START)
