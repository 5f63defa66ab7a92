"""One small task for all tests here: its programs are compiled once."""

import pytest

from physagent_jax.mpm import window
from tests.baselines.tiny import TinyTask, act, make_tiny_task

HIDDEN = act("translation", (-0.9, 0.1, 0.4), 1.3)
START = act("translation", (0.3, 0.5, 0.1), 0.8)


@pytest.fixture(autouse=True, scope="package")
def one_window():
    """Give the first grid window room for the whole clip: each other one has every program compiled again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(window, "ROOM", 2.0)
        yield


@pytest.fixture(scope="session")
def tiny(tmp_path_factory) -> TinyTask:
    return make_tiny_task(tmp_path_factory.mktemp("tiny"), HIDDEN, START)
