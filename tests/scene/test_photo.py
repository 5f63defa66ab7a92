"""One photo as an object: cut out, lifted, seen again from its own camera."""

import json
import warnings

import numpy as np
import pytest
from PIL import Image

import physagent_jax as pa
from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import DEPTH_ESTIMATORS, SEGMENTERS
from physagent_jax.perception.protocols import Depth, DepthEstimator, Masks, Segmenter
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene.body import make_scene_body
from physagent_jax.scene.config import (
    CameraConfig,
    Filling,
    Photo,
    SceneConfig,
    Source,
    dump_scene,
    parse_scene,
)
from physagent_jax.scene.load import load_object
from physagent_jax.scene.photo.lift import lift_photo
from physagent_jax.scene.photo.solid import inflate
from physagent_jax.simulation.presentation import draw_presentation
from tests.scene.photos import (
    BALL_VOLUME,
    HEIGHT,
    WIDTH,
    draw_background,
    make_ball_mask,
    make_post_mask,
    measure_overlap,
    write_photo,
)

MASKS = {"ball": make_ball_mask(), "post": make_post_mask()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("photos")
    for name, mask in MASKS.items():
        write_photo(path / f"{name}.png", mask)
    return path


@pytest.fixture(scope="module")
def loaded(folder):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return {name: pa.load_object(folder / f"{name}.png", cells=64, max_particles=6000) for name in MASKS}


@pytest.mark.parametrize("name", MASKS)
def test_what_stands_out_is_cut_out(folder, name):
    mask = lift_photo(folder / f"{name}.png", Photo(), folder).mask
    assert measure_overlap(mask, MASKS[name]) > 0.95


def test_a_box_chooses_one_of_two(tmp_path):
    small = make_ball_mask(16, (30, 60))
    write_photo(tmp_path / "two.png", small | make_ball_mask(26, (110, 60)))
    mask = lift_photo(tmp_path / "two.png", Photo(box=(8, 38, 52, 82)), tmp_path).mask
    assert measure_overlap(mask, small) > 0.9


def test_an_inflated_circle_is_nearly_a_ball():
    square = inflate(make_ball_mask())  # the equation's right side is 3, where a ball needs 4
    # The foot, cut flat, and the half that is its image add some.
    assert np.sqrt(square.max()) == pytest.approx(34 * np.sqrt(3 / 4), rel=0.08)
    above = np.s_[:90]  # of the foot, under which its image lies
    assert square[above][~make_ball_mask()[above]].max() < 0.05 * square.max()


def test_a_flat_foot_is_as_thick_as_the_rest():
    half = np.sqrt(inflate(make_post_mask()))
    assert half[103, 70] > 0.9 * half[62, 70] > 0, "the post stands on its end"
    assert half[21, 70] < 0.5 * half[62, 70], "and is rounded off at its head"


def test_volumes_are_those_of_round_bodies(loaded):
    assert loaded["ball"].body.particles.volume.sum() == pytest.approx(BALL_VOLUME, rel=0.3)
    radius = 12 / 84  # of the longest side
    assert loaded["post"].body.particles.volume.sum() == pytest.approx(np.pi * radius**2, rel=0.5)


def test_from_aside_a_ball_is_nearly_round(loaded):
    means = np.asarray(loaded["ball"].body.cloud.means)
    for azimuth in (30, 60):
        angle = np.radians(azimuth)
        across = means[:, 0] * np.cos(angle) + means[:, 1] * np.sin(angle)
        assert np.ptp(across) == pytest.approx(np.ptp(means[:, 2]), rel=0.2)


@pytest.mark.parametrize("name", MASKS)
@pytest.mark.parametrize("elevation", [0.0, 10.0, 40.0, 75.0])
def test_each_point_stays_on_its_pixel(folder, name, elevation):
    lifted = lift_photo(folder / f"{name}.png", Photo(elevation_degrees=elevation), folder)
    seen = np.asarray(lifted.cloud.means, np.float64) @ lifted.turn.T
    assert (seen[:, 2] > 0).all()
    places = lifted.focal * HEIGHT * seen[:, :2] / seen[:, 2:] + [WIDTH / 2, HEIGHT / 2]
    drawn = np.zeros((HEIGHT, WIDTH), bool)
    column, row = np.floor(places).astype(int).T
    drawn[row, column] = True
    assert measure_overlap(drawn, lifted.mask) > 0.9
    grown = np.asarray(Image.fromarray(lifted.mask).convert("L").resize((WIDTH, HEIGHT))) > 0
    rows, columns = np.nonzero(grown)
    assert column.min() >= columns.min() - 2 and column.max() <= columns.max() + 2
    assert row.min() >= rows.min() - 2 and row.max() <= rows.max() + 2


def test_the_foot_is_level_and_gaussians_are_opaque_and_small(loaded):
    body = loaded["post"].body
    low = np.asarray(body.cloud.means)[:, 2]
    foot = np.asarray(body.cloud.means)[low < low.min() + 1e-4]
    assert np.ptp(foot[:, 0]) > 0.2 and np.ptp(foot[:, 1]) > 0.1, "it stands on an area"
    assert np.asarray(body.cloud.opacities).min() > 0.9
    assert np.median(np.asarray(body.cloud.scales).max(1)) < 1.5 / 84, "a pixel or so"


def test_what_the_picture_cuts_off_ends_there_and_is_closed(tmp_path):
    mask = make_post_mask() | np.roll(make_post_mask(), 16, axis=0)  # down to the last row
    write_photo(tmp_path / "cut.png", mask)
    np.save(tmp_path / "mask.npy", mask)
    lifted = lift_photo(tmp_path / "cut.png", Photo(mask_path="mask.npy"), tmp_path)
    assert any("cut off by the photo's edge (bottom)" in note for note in lifted.notes)
    means = np.asarray(lifted.cloud.means)
    foot = means[means[:, 2] < means[:, 2].min() + 0.5]
    across, away = (np.histogram(foot[:, axis], bins=6)[0] for axis in (0, 1))
    assert across.min() > 0 and away.min() > 0, "there are Gaussians all over the foot"


def test_the_first_picture_is_the_photo(folder, loaded):
    body = loaded["ball"].body
    x = np.asarray(body.particles.x)[None]
    F = np.eye(3, dtype=np.float32)[None, None].repeat(x.shape[1], axis=1)
    config = SceneConfig(source=loaded["ball"].source, camera=CameraConfig())
    (picture,) = draw_presentation(config, body, x, F, (WIDTH, HEIGHT))
    photo = np.asarray(Image.open(folder / "ball.png"))
    error = (picture.astype(float) - photo) ** 2 / 255**2
    assert -10 * np.log10(error[MASKS["ball"]].mean()) > 22
    grown = make_ball_mask(40)
    assert error[~grown].mean() < 1e-4, "all else stays as it was"
    hole = body.photo.lifted.plate[MASKS["ball"]].astype(float) / 255
    assert (hole[:, 0] < hole[:, 2] + 0.2).mean() > 0.9, "nothing warm is left where the object was"


def test_a_photo_keeps_its_shape_within_the_video(loaded):
    view = loaded["ball"].body.photo
    assert view.is_of(CameraConfig(azimuth_degrees=360.0))
    for other in (dict(azimuth_degrees=30.0), dict(elevation_degrees=20.0), dict(follow=True)):
        assert not view.is_of(CameraConfig(**other)), "other cameras show the usual stage"
    camera = view.make_camera((1280, 720))
    assert (camera.width, camera.height) == (960, 720)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_scene_file_replays_from_the_photo(folder, loaded):
    source = loaded["ball"].source.model_copy(update=dict(path="ball.png"))
    config = SceneConfig(source=source, filling=Filling(max_particles=500))
    body = make_scene_body(parse_scene(json.loads(dump_scene(config))), folder)
    assert (body.photo.lifted.plate == loaded["ball"].body.photo.lifted.plate).all()
    np.testing.assert_array_equal(np.asarray(body.cloud.sh), np.asarray(loaded["ball"].body.cloud.sh))


@pytest.mark.usefixtures("quick_plans")
def test_a_photo_can_be_inspected(folder):
    found = pa.inspect_object(folder / "ball.png")
    assert found.up.axis == "+z" and found.up.known
    assert any("made up" in note for note in found.notes)
    assert "--image" in found.command and "--up" not in found.command


def test_what_is_made_up_is_said(folder):
    with pytest.warns(UserWarning) as told:
        found = load_object(Source(path="post.png"), folder)
    text = " ".join(str(each.message) for each in told)
    for word in ("one side", "back", "depth", "size", "field of view", "assumed"):
        assert word in text
    assert found.up == "+z" and found.format_name == "photo"


def test_exif_data_tell_the_lens(tmp_path):
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0xA405] = 50  # 35 mm equivalent [mm]
    write_photo(tmp_path / "a.jpg", MASKS["ball"], exif=exif, quality=95)
    lifted = lift_photo(tmp_path / "a.jpg", Photo(), tmp_path)
    diagonal = 2 * np.degrees(np.arctan(0.5 * np.hypot(WIDTH, HEIGHT) / (lifted.focal * HEIGHT)))
    assert diagonal == pytest.approx(46.8, abs=0.2)  # of a 50 mm lens on 36 x 24 mm
    assert any("EXIF" in note for note in lifted.notes)


def test_a_depth_that_is_given_makes_the_relief(folder, tmp_path):
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    ramp = np.float32(2 + (x - 80) / 100)  # the right side is farther away
    np.save(tmp_path / "depth.npy", ramp)
    lifted = lift_photo(folder / "ball.png", Photo(depth_path=str(tmp_path / "depth.npy")), folder)
    means = np.asarray(lifted.cloud.means)
    right = means[:, 0] > 0
    assert means[right, 1].mean() > means[~right, 1].mean() + 20
    assert any("depth is estimated" in note for note in lifted.notes)


class FixedSegmenter(Segmenter):
    """Finds a small ball whatever it is shown."""

    def segment(self, frames, prompt, depth=None):
        return Masks(np.stack([make_ball_mask(20)] * len(frames)))


class FlatDepth(DepthEstimator):
    """Sees a wall."""

    def estimate(self, frames, camera, measured):
        return Depth(np.full(frames.shape[:3], 3.0, np.float32), scale_known=False)


def test_models_are_asked_by_name_and_their_answers_kept(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setitem(SEGMENTERS.entries, "fixed", f"{__name__}:FixedSegmenter")
    monkeypatch.setitem(DEPTH_ESTIMATORS.entries, "flat", f"{__name__}:FlatDepth")
    chosen = {"path": str(folder / "ball.png"), "photo": {"segmenter": "fixed", "depth": "flat"}}
    photo = resolve(RunSpec.model_validate({"object": chosen, "prompt": ""})).template.source.photo
    assert photo is not None
    lifted = lift_photo(folder / "ball.png", photo, folder)
    assert (lifted.mask == make_ball_mask(20)).all()
    front = np.asarray(lifted.cloud.means)[:, 1].min()
    assert front == pytest.approx(np.asarray(lifted.cloud.means)[:, 1].max() - 35, abs=12), "a wall, inflated"


def test_another_box_is_another_run_and_another_place_of_the_mask_is_not(folder, tmp_path):
    def identify(**photo):
        chosen = {"path": str(folder / "ball.png"), "photo": photo}
        return resolve(RunSpec.model_validate({"object": chosen, "prompt": ""})).inputs

    assert identify(box=(40, 20, 120, 110)) != identify(box=(40, 20, 120, 112))
    for name in ("a.npy", "b.npy"):
        np.save(tmp_path / name, MASKS["ball"])
    first, second = (identify(mask_path=str(tmp_path / name)) for name in ("a.npy", "b.npy"))
    assert first == second
    located = RunSpec.model_validate(
        {"object": {"path": "ball.png", "photo": {"mask_path": "a.npy"}}, "prompt": ""}
    ).located(tmp_path)
    assert located.object.photo.mask_path == str(tmp_path / "a.npy")


def test_only_models_that_there_are_can_be_named(folder):
    with pytest.raises(UserError, match="nobody"):
        pa.load_object(folder / "ball.png", photo={"segmenter": "nobody"})


def refuse(path, match, **photo):
    with pytest.raises(UserError, match=match):
        lift_photo(path, Photo(**photo), path.parent)


def test_pictures_that_show_no_object_are_refused(tmp_path):
    Image.fromarray(np.full((HEIGHT, WIDTH, 3), 200, np.uint8)).save(tmp_path / "plain.png")
    refuse(tmp_path / "plain.png", "no object stands out|too small")
    background = np.uint8(255 * draw_background())
    Image.fromarray(background).save(tmp_path / "wall.png")
    frame, speck = np.ones((HEIGHT, WIDTH), bool), make_ball_mask(4)
    frame[20:100, 20:140] = False
    for name, mask, match in (
        ("none", frame & False, "no object stands out"),
        ("frame", frame, "touches all of its borders"),
        ("speck", speck, "too small"),
        ("other", frame[:50], "another size"),
    ):
        np.save(tmp_path / f"{name}.npy", mask)
        refuse(tmp_path / "wall.png", match, mask_path=f"{name}.npy")
    refuse(tmp_path / "wall.png", "outside", box=(500, 0, 600, 50))
    refuse(tmp_path / "wall.png", "cannot read", mask_path="gone.npy")


def test_masks_are_pictures_or_arrays(folder, tmp_path):
    Image.fromarray(np.uint8(255 * MASKS["ball"])).save(tmp_path / "mask.png")
    np.save(tmp_path / "mask.npy", MASKS["ball"])
    for name in ("mask.png", "mask.npy"):
        lifted = lift_photo(folder / "ball.png", Photo(mask_path=str(tmp_path / name)), folder)
        assert (lifted.mask == MASKS["ball"]).all()


@pytest.mark.parametrize("content", [b"\x89PNG\r\n\x1a\n" + bytes(40), b"\xff\xd8\xff" + bytes(9), b"BM"])
def test_broken_pictures_are_one_error(tmp_path, content):
    (tmp_path / "x.png").write_bytes(content)
    refuse(tmp_path / "x.png", "no image that can be read")


def test_what_is_no_image_cannot_be_lifted(robot_path, folder):
    with pytest.raises(UserError, match="is no image"):
        pa.load_object(robot_path, photo={})
    with pytest.raises(UserError, match="means nothing for an image"):
        pa.load_object(folder / "ball.png", up="-y")
