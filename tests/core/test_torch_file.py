"""Files of `torch.save`, packed by hand: tensors come out, and nothing else is done."""

import struct
import zipfile

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.core.torch_file import read_torch_file

VALUES = np.arange(24, dtype=np.float32)
DATA = VALUES.tobytes()


def text(value):
    return b"X" + struct.pack("<I", len(value)) + value.encode()


def whole(value):
    return b"J" + struct.pack("<i", value)


def many(values):
    return b"(" + b"".join(map(whole, values)) + b"t"


def tensor(
    shape, strides, offset=0, *, kind="FloatStorage", count=24, make="torch._utils\n_rebuild_tensor_v2"
):
    storage = (
        b"("
        + text("storage")
        + f"ctorch\n{kind}\n".encode()
        + text("0")
        + text("cuda:0")
        + whole(count)
        + b"tQ"
    )
    arguments = storage + whole(offset) + many(shape) + many(strides) + b"\x89ccollections\nOrderedDict\n)R"
    return f"c{make}\n".encode() + b"(" + arguments + b"tR"


def entries(**items):
    return b"}(" + b"".join(text(name) + value for name, value in items.items()) + b"u"


def pack(path, body, data=DATA, *, compression=zipfile.ZIP_STORED, **more):
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr("archive/data.pkl", b"\x80\x02" + body + b".")
        archive.writestr("archive/data/0", data)
        for name, value in more.items():
            archive.writestr(f"archive/{name}", value)
    return path


def read(path):
    return read_torch_file(path, most=10**6)


@pytest.mark.parametrize("holder", ["", "model"])
def test_tensors_are_read_with_their_strides(tmp_path, holder):
    """Also from beside an optimiser's numbers, where one dictionary holds nothing else."""
    body = entries(turned=tensor((4, 6), (1, 4)), part=tensor((3,), (2,), 5), none=tensor((0, 3), (3, 1)))
    if holder:
        body = entries(epoch=whole(3), model=body)
    found = read(pack(tmp_path / "a.pth", body, byteorder="little"))
    assert np.array_equal(found["turned"], VALUES.reshape(6, 4).T)
    assert found["part"].tolist() == [5, 7, 9] and found["none"].shape == (0, 3)


def test_half_precision_is_read_in_its_own_type(tmp_path):
    data = np.arange(24, dtype=np.float16).tobytes()
    found = read(pack(tmp_path / "a.pth", entries(a=tensor((24,), (1,), kind="HalfStorage")), data))
    assert found["a"].dtype == np.float16 and found["a"][-1] == 23


REFUSED = {
    "a call of the system": (b"cos\nsystem\n(" + text("touch SHOUT") + b"tR", "`os.system`"),
    "a call by a newer instruction": (
        text("os") + text("system") + b"\x93(" + text("true") + b"tR",
        "STACK_GLOBAL",
    ),
    "an object": (b"(ios\nsystem\n", "instruction INST"),
    "another maker of tensors": (
        entries(a=tensor((3,), (1,), make="torch._utils\n_rebuild_qtensor")),
        "`torch._utils._rebuild_qtensor`",
    ),
    "a name as text": (text("collections OrderedDict") + b")R", "is refused"),
    "another storage": (entries(a=tensor((3,), (1,), kind="load")), "no storage of numbers"),
    "a tensor beyond its storage": (entries(a=tensor((4, 6), (6, 1), 1)), "larger than its storage"),
    "a tensor that repeats its storage": (entries(a=tensor((1000, 1000), (0, 0))), "larger than its storage"),
    "a negative step": (entries(a=tensor((3,), (-1,), 4)), "no possible shape"),
    "a storage of another size": (entries(a=tensor((3,), (1,), count=25)), "bytes instead of 100"),
    "a list": (b"](K\x01K\x02e", "no dictionary of tensors"),
    "numbers": (entries(a=whole(1)), "no dictionary of tensors"),
    "no end": (b"}K", "no file of `torch.save`"),
}


@pytest.mark.parametrize("body, words", REFUSED.values(), ids=REFUSED)
def test_what_is_more_than_tensors_is_refused_and_not_run(tmp_path, monkeypatch, body, words):
    monkeypatch.chdir(tmp_path)
    path = pack(tmp_path / "a.pth", body)
    with pytest.raises(UserError) as caught:
        read(path)
    assert words in str(caught.value) and "safetensors" in str(caught.value)
    assert not (tmp_path / "SHOUT").exists()


def test_archives_of_another_kind_are_refused(tmp_path):
    body = entries(a=tensor((3,), (1,)))
    with pytest.raises(UserError, match="compressed"):
        read(pack(tmp_path / "a.pth", body, compression=zipfile.ZIP_DEFLATED))
    with pytest.raises(UserError, match="highest byte first"):
        read(pack(tmp_path / "b.pth", body, byteorder="big"))
    (tmp_path / "c.pth").write_bytes(b"\x80\x02}q\x00.")
    with pytest.raises(UserError, match="no file of `torch.save`"):
        read(tmp_path / "c.pth")
    with pytest.raises(UserError, match="there is no checkpoint"):
        read(tmp_path / "d.pth")
    with pytest.raises(UserError, match="larger|at most|bytes"):
        read_torch_file(pack(tmp_path / "e.pth", body), most=100)


def test_a_mutilated_file_is_told_in_one_line_or_read(tmp_path):
    draw = np.random.default_rng(0)
    original = pack(
        tmp_path / "a.pth", entries(a=tensor((4, 6), (1, 4)), b=tensor((3,), (2,), 5))
    ).read_bytes()
    for _ in range(300):
        changed = bytearray(original)
        for at in draw.integers(0, len(changed), draw.integers(1, 4)):
            changed[at] = draw.integers(256)
        (tmp_path / "b.pth").write_bytes(changed)
        try:
            found = read(tmp_path / "b.pth")
        except UserError as error:
            assert "\n" not in str(error)
        else:
            assert all(isinstance(each, np.ndarray) for each in found.values())
