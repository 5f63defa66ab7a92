"""`physagent inspect`: what a file holds, which way up it is, a picture, and the command that begins a run."""

import io
import json
import shlex
import zlib
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
import trimesh

import physagent_jax as pa
from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import GaussianCloud, write_ply
from physagent_jax.run import preview
from physagent_jax.run.preview import HEIGHT, WIDTH, is_preview
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene.procedural import PROCEDURAL

quickly = pytest.mark.usefixtures("quick_plans")
FIELDS = set(
    "path format encoding content count kept low high extent origin up kind pieces parts degenerate notes run refusal "
    "command preview".split()
)


@pytest.fixture(autouse=True)
def in_a_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("PHYSAGENT_COMPILE_CACHE", "off")
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def small_picture(monkeypatch):
    """Draw a picture that nobody looks at with a tenth of its pixels."""
    monkeypatch.setattr(preview, "WIDTH", WIDTH // 4)
    monkeypatch.setattr(preview, "HEIGHT", HEIGHT // 3)


drawn_small = pytest.mark.usefixtures("small_picture")


@pytest.fixture
def cone(tmp_path):
    """A cone of height 2 on its foot, y-up, in an OBJ whose name says what it is."""
    mesh = trimesh.creation.cone(radius=0.6, height=2.0)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    mesh.export(tmp_path / "toy_cone.obj")
    return tmp_path / "toy_cone.obj"


def inspect(capsys, *arguments):
    assert main(["inspect", *map(str, arguments)]) == 0
    return capsys.readouterr().out


def refused(capsys, *arguments):
    assert main(["inspect", *map(str, arguments)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("physagent: ") and error.count("\n") == 1 and "Traceback" not in error
    return error


def find_facts(path, **options):
    """The object that the command prints with ``--json``, without a picture, which takes longest."""
    return json.loads(pa.inspect_object(path, **options).model_dump_json())


@quickly
@drawn_small
def test_the_json_object(robot_path, tmp_path, capsys):
    """The command prints what `inspect_object` returns, and writes the picture that it names."""
    said = json.loads(inspect(capsys, robot_path, "--json"))
    assert is_preview(tmp_path / said["preview"])
    assert said == {**find_facts(robot_path), "preview": "robot.preview.png"}


def test_a_mesh(cone):
    """All fields, against what is known of the cone."""
    said = find_facts(cone)
    assert set(said) == FIELDS
    assert (said["format"], said["content"]) == ("OBJ mesh", "triangles")
    assert said["count"] == said["kept"] == len(trimesh.load(cone).faces)
    assert said["extent"] == pytest.approx([1.2, 2.0, 1.2], abs=1e-3)
    assert np.subtract(said["high"], said["low"]) == pytest.approx(said["extent"])
    assert (said["up"]["axis"], said["up"]["known"], said["up"]["source"]) == ("+y", True, "shape")
    assert "its -y side is flat" in said["up"]["reason"]
    assert (said["kind"]["kind"], said["kind"]["known"]) == ("toy", True)
    assert said["pieces"] == said["degenerate"] == [] and said["refusal"] is None
    run = said["run"]
    assert (run["preset"], run["cells"], run["frames"]) == ("fast", 96, 50) and run["particles"] <= 20_000
    assert run["object_cells"] == pytest.approx(24, rel=0.01)
    assert run["substeps"] > 100 and run["seconds"] > 1 and run["memory"] > 1e8


@quickly
def test_the_command_line_begins_a_run(robot_path, tmp_path, capsys, monkeypatch):
    """The suggested command is accepted by `physagent run`, and says the same of the object."""
    spaced = tmp_path / "a robot's copy.ply"
    spaced.write_bytes(robot_path.read_bytes())
    said = find_facts(spaced, opacity_threshold=0.1)
    words = shlex.split(said["command"])
    assert words[:2] == ["physagent", "run"]
    begun = []

    def stop(run, out, **_):
        begun.append((run, out))
        raise UserError("enough")

    monkeypatch.setattr("physagent_jax.run.loop.run_loop", stop)
    assert main(words[1:]) == 2 and "enough" in capsys.readouterr().err
    ((run, out),) = begun
    source = run.template.source
    assert (source.path, source.up, source.kind) == (str(spaced), said["up"]["axis"], "robot")
    assert source.opacity_threshold == 0.1 and str(out) == "runs/a robot's copy"


@drawn_small
def test_gaussians_in_words(robot_path, tmp_path, capsys):
    """The card is heeded; a thousandth of the size can be told in the corners."""
    out = inspect(capsys, robot_path)
    lines = dict(line.split(maxsplit=1) for line in out.splitlines())
    assert lines["format"].startswith("3DGS PLY (log scales, logit opacities, SH of degree 2")
    assert lines["holds"] == "3,835 Gaussians, all kept"
    assert lines["up"] == "-y: the card beside the file says so"
    assert lines["kind"] == "robot: the card beside the file says so"
    assert "--up -y --kind robot" in lines["command"] and lines["picture"] == "robot.preview.png"
    assert "12," in lines["run"] and "particles" in lines["run"] and "a round" in lines["run"]


@quickly
@drawn_small
def test_what_is_not_known_is_said(robot_path, tmp_path, capsys):
    """A floating object without a card: the usual axis is tried, and called a try."""
    (tmp_path / "thing.ply").write_bytes(robot_path.read_bytes())
    said = find_facts("thing.ply")
    assert (said["up"]["axis"], said["up"]["known"], said["up"]["source"]) == ("-y", False, "usual")
    assert "does not tell" in said["up"]["reason"] and "-y is tried" in said["up"]["reason"]
    assert not said["kind"]["known"] and "--kind" not in said["command"] and "robot" in said["kind"]["reason"]
    assert "up        not known: " in inspect(capsys, "thing.ply")


@quickly
def test_no_mesh_is_modelled_on_its_side(tmp_path):
    """Flat backs are no bases: a trophy's is along -z, which no program that makes meshes takes for up."""
    trimesh.creation.cone(1.0, 2.0).apply_transform(np.diag([1.0, 1, -1, 1])).export(tmp_path / "trophy.obj")
    up = find_facts("trophy.obj")["up"]
    assert (up["axis"], up["known"], up["source"]) == ("+y", False, "usual")
    assert "the shape says -z" in up["reason"] and "+y is tried" in up["reason"]


@quickly
def test_options_go_first(cone):
    """The user's axis is not guessed; a shape that contradicts it is mentioned."""
    said = find_facts(cone, up="+z", kind="ficus")
    assert (said["up"]["axis"], said["up"]["source"], said["kind"]["kind"]) == ("+z", "option", "plant")
    assert "though the shape says +y" in said["up"]["reason"] and "--up +z --kind plant" in said["command"]


@quickly
def test_a_gltf_is_y_up(tmp_path):
    """As glTF 2.0 prescribes, whatever the shape."""
    trimesh.creation.icosphere().export(tmp_path / "ball.glb")
    said = find_facts("ball.glb")
    assert (said["up"]["axis"], said["up"]["known"], said["up"]["source"]) == ("+y", True, "format")


def test_loose_pieces(tmp_path):
    """A cube and a smaller one half a length away: its share is between those of volumes and of surfaces."""
    small = trimesh.creation.box([0.2, 0.2, 0.2]).apply_translation([0.9, 0, 0])
    trimesh.util.concatenate([trimesh.creation.box([0.4, 0.4, 0.4]), small]).export(tmp_path / "pair.obj")
    said = find_facts("pair.obj")
    ((piece),) = said["pieces"]
    assert piece["distance"] == pytest.approx(0.5, abs=0.05)  # 0.6 of 1.2
    assert 1 / 9 < piece["share"] < 1 / 5
    assert not any("joined to the rest" in note for note in said["notes"])


@quickly
def test_gaussians_that_are_out_of_the_ordinary(tmp_path):
    """A cloud that is one blob, and one of Gaussians as large as itself, which a run refuses."""
    jelly = PROCEDURAL["jelly"](0)
    for factor, words, refused in ((12, "blur into one blob", False), (40, "as large as the object", True)):
        blob = GaussianCloud(jelly.means, jelly.quats, factor * jelly.scales, jelly.opacities, jelly.sh)
        write_ply(tmp_path / "jelly.ply", blob)
        said = find_facts("jelly.ply", splat_encoding="log-logit")
        assert len(said["degenerate"]) == 1 and words in said["degenerate"][0]
        assert said["degenerate"][0] not in said["notes"]
        assert "--splat-encoding log-logit" in said["command"]
        assert (said["run"] is None) == (said["refusal"] is not None) == refused


@quickly
@drawn_small
def test_far_from_the_origin(tmp_path, capsys):
    """Positions in double precision at map coordinates: the origin is told, and the corners are those of the file."""
    from plyfile import PlyData, PlyElement

    jelly, place = PROCEDURAL["jelly"](0), np.array([499_000.0, 5_400_000.0, 300.0])
    write_ply(tmp_path / "near.ply", jelly)
    table = PlyData.read(str(tmp_path / "near.ply"))["vertex"].data
    kinds = [(name, "<f8" if name in "xyz" else "<f4") for name in table.dtype.names]
    far = np.empty(len(table), kinds)
    for name in table.dtype.names:
        far[name] = table[name] + (place["xyz".index(name)] if name in "xyz" else 0)
    PlyData([PlyElement.describe(far, "vertex")]).write(str(tmp_path / "far.ply"))
    said = find_facts("far.ply")
    low = np.asarray(jelly.means, np.float64).min(0) + place
    assert said["low"] == pytest.approx(low.tolist(), abs=1e-6)
    assert np.abs(np.subtract(said["origin"], place)).max() < 2 and said["up"]["axis"] == "+z"
    out = inspect(capsys, "far.ply")
    assert f"({low[0]:.3f}, {low[1]:.3f}, {low[2]:.3f})" in out and "was taken off" in out


@quickly
def test_the_picture(tmp_path, capsys):
    """Four views in which the red jelly, which is broader at its foot, stands upright; on its head it is not."""
    write_ply(tmp_path / "jelly.ply", PROCEDURAL["jelly"](0))
    inspect(capsys, "jelly.ply", "--out", "upright.png")
    inspect(capsys, "jelly.ply", "--out", "turned.png", "--up", "-z")
    upright, turned = iio.imread("upright.png"), iio.imread("turned.png")
    assert upright.shape == turned.shape == (2 * HEIGHT, 2 * WIDTH, 3)
    for row, column in np.ndindex(2, 2):
        view = np.s_[row * HEIGHT : (row + 1) * HEIGHT, column * WIDTH : (column + 1) * WIDTH]
        assert 0.5 < compare_ends(upright[view]) < 1 < 1.1 < compare_ends(turned[view])


@quickly
def test_light_comes_from_above(tmp_path, capsys):
    """A grey ball that is y-up is brighter above than below, whatever axis the reader assumes at first."""
    trimesh.creation.icosphere(subdivisions=4).export(tmp_path / "ball.glb")
    inspect(capsys, "ball.glb", "--out", "ball.png")
    picture = iio.imread("ball.png").astype(float).mean(axis=2)
    for row, column in np.ndindex(2, 2):
        view = picture[row * HEIGHT : (row + 1) * HEIGHT, column * WIDTH : (column + 1) * WIDTH]
        middle = view[:, WIDTH // 2 - 10 : WIDTH // 2 + 10].mean(axis=1)
        assert middle[60:120].mean() > 1.15 * middle[260:320].mean()


def compare_ends(view):
    """Width of what is red over its third from above, over the same from below."""
    middle = view[50:, 120:-120].astype(int)  # without labels and axes
    red = middle[..., 0] - middle[..., 1] > 60
    rows = np.flatnonzero(red.sum(axis=1) > 20)
    assert len(rows) > HEIGHT // 4 and red.mean() > 0.1
    widths = red[rows[0] : rows[-1] + 1].sum(axis=1)
    return widths[: len(widths) // 3].mean() / widths[-len(widths) // 3 :].mean()


@quickly
@drawn_small
def test_the_picture_is_a_valid_png_with_its_mark(robot_path, capsys):
    """Every chunk's checksum holds."""
    inspect(capsys, robot_path)
    data = Path("robot.preview.png").read_bytes()
    at, kinds = 8, []
    while at < len(data):
        size, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8]
        body = data[at + 4 : at + 8 + size]
        assert int.from_bytes(data[at + 8 + size : at + 12 + size], "big") == zlib.crc32(body)
        kinds.append(kind)
        at += 12 + size
    assert kinds[:2] == [b"IHDR", b"tEXt"] and kinds[-1] == b"IEND"


@quickly
@drawn_small
def test_a_preview_is_replaced_and_nothing_else(robot_path, tmp_path, capsys):
    """Another picture of that name stays, unless told otherwise; an earlier preview makes way."""
    mine = io.BytesIO()
    iio.imwrite(mine, np.zeros((4, 4, 3), np.uint8), extension=".png")
    (tmp_path / "mine.png").write_bytes(mine.getvalue())
    assert "mine.png exists" in refused(capsys, robot_path, "--out", "mine.png")
    assert (tmp_path / "mine.png").read_bytes() == mine.getvalue()
    inspect(capsys, robot_path, "--out", "mine.png", "--overwrite")
    first = (tmp_path / "mine.png").read_bytes()
    inspect(capsys, robot_path, "--out", "mine.png", "--up", "+y")
    assert (tmp_path / "mine.png").read_bytes() != first


@pytest.mark.parametrize("out", ["picture.jpg", "folder", "/dev/null", "toy_cone.obj/x.png"])
def test_places_that_are_none(out, cone, tmp_path, capsys):
    (tmp_path / "folder").mkdir()
    before = cone.read_bytes()
    refused(capsys, cone, "--out", out)
    assert cone.read_bytes() == before and not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize("case", ["missing", "text", "truncated", "picture", "arrays", "folder"])
def test_files_that_cannot_be_read(case, robot_path, tmp_path, capsys):
    """The reader's one line, exit code 2, and no picture."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "text").write_text("hello")
    (tmp_path / "truncated.ply").write_bytes(robot_path.read_bytes()[:4000])
    iio.imwrite(tmp_path / "picture.png", np.zeros((9, 9, 3), np.uint8))
    np.savez(tmp_path / "arrays.npz", x=np.zeros(3))
    names = {"picture": "picture.png", "arrays": "arrays.npz", "truncated": "truncated.ply"}
    name = names.get(case, case)
    assert name in refused(capsys, name, "--out", "out.png")
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize(
    "options", [("--kind", "xyzzy"), ("--opacity-threshold", "1.5"), ("--opacity-threshold", "nan")]
)
def test_options_that_mean_nothing(options, robot_path, tmp_path, capsys):
    error = refused(capsys, robot_path, *options)
    assert options[0] in error and not list(tmp_path.glob("*.png"))


@drawn_small
def test_a_run_that_would_be_refused(robot_path, monkeypatch, capsys):
    """The facts and the picture are there all the same, with the reason."""
    monkeypatch.setattr("physagent_jax.scene.cost.read_machine_memory", lambda: 1e8)
    out = inspect(capsys, robot_path)
    assert "\nrefused   this would take at least" in out and "\npicture" in out and "\ncommand" not in out


@quickly
def test_from_python(robot_path, tmp_path):
    """The same by `inspect_object`, which draws nothing unless asked, and warns of nothing."""
    found = pa.inspect_object(robot_path)
    assert isinstance(found, pa.Inspection) and found.preview is None and not list(tmp_path.glob("*.png"))
    assert found.up.axis == "-y" and found.count == 3835
    assert RunSpec.model_validate(dict(object=dict(path=found.path, up=found.up.axis), prompt=""))
    with pytest.raises(UserError, match="gone.ply"):
        pa.inspect_object(tmp_path / "gone.ply")


def test_real_files(shared_data, tmp_path, capsys):
    """The largest of them, with what its source says of it; what is no object is refused."""
    said = find_facts(shared_data / "guitar_sh0.ply")
    assert said["count"] == 84_130 and said["up"]["axis"] == "-y" and said["kind"]["kind"] == "instrument"
    assert said["low"] == pytest.approx([-0.66, -4.29, -0.53], abs=0.01)
    assert said["high"] == pytest.approx([0.82, 0.09, 0.92], abs=0.01)
    assert "test_garden.npz" in refused(capsys, shared_data / "test_garden.npz")
    assert find_facts(shared_data / "coffee.png")["format"] == "photo", "a picture of an object is one"
