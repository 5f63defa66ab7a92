"""The first picture before anything is simulated: what cannot be measured is refused, all else is let through."""

import dataclasses
import math

import numpy as np
import pytest

from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.motion.schema import Judgement
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.protocols import Masks, Segmenter, SegmentPrompt
from physagent_jax.perception.schema import MotionReport
from physagent_jax.report.html import write_report
from physagent_jax.run.first_picture import (
    check_first_picture,
    draw_first_picture,
    is_in_doubt,
    measure_length,
)
from physagent_jax.run.resolve import resolve
from physagent_jax.scene.body import make_body
from physagent_jax.scene.fuse import fuse
from tests.run.specs import made, small
from tests.scene.clouds import cloud_of

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")  # of few particles and loose pieces

BALL = np.random.default_rng(0).normal(size=(1500, 3))
BALL *= (
    0.5 * np.random.default_rng(1).uniform(size=(1500, 1)) ** (1 / 3) / np.linalg.norm(BALL, axis=1)[:, None]
)
POLE = BALL * [0.003, 0.003, 1]


def make_ready(path, cloud, *, resolution=64, **parts):
    """The scene and the body of a run on ``cloud``, as the loop checks them."""
    write_ply(path / "object.ply", cloud)
    parts["object"] = {"path": str(path / "object.ply"), "up": "+z", **parts.get("object", {})}
    run = resolve(small(path, "push it to the left", resolution=resolution, **parts))
    preset = run.template.preset
    body = make_body(run.template.source, preset.filling, preset.domain, run.base_dir)
    return fuse(run.place(body)[0], body, ForceField()), body


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """The scene and the body of an ordinary ball."""
    return make_ready(tmp_path_factory.mktemp("ball"), cloud_of(BALL, scale=0.03))


def test_an_object_of_ordinary_gaussians_is_let_through(ball):
    config, body = ball
    assert check_first_picture(config, body) == () and not is_in_doubt(body)
    image = draw_first_picture(config, body)
    assert image.rgb.shape == (64, 64, 3) and 0.05 < np.asarray(image.alpha > 0.5).mean() < 0.6


@pytest.mark.parametrize(
    ("cloud", "words", "do"),
    [
        (cloud_of(BALL, scale=0.42), "fills perception's picture.*100% of the border", "logarithms"),
        (cloud_of(BALL, scale=0.03, opacity=0.0039), "fainter than 0.0039", "--opacity-threshold"),
    ],
    ids=["nearly as large as the object", "fainter than is drawn"],
)
def test_what_cannot_be_measured_is_refused(cloud, words, do, tmp_path):
    choice = dict(path=str(tmp_path / "object.ply"), opacity_threshold=0.0)
    config, body = make_ready(tmp_path, cloud, object=choice)
    with pytest.raises(UserError, match=f"{words}.*{do}"):
        check_first_picture(config, body)
    assert is_in_doubt(body)


def test_an_object_outside_of_the_picture_is_refused(ball):
    """The camera is placed for the object; a scene's own may look elsewhere, or stand in it."""
    config, body = ball
    aside = config.camera.model_copy(update=dict(target=tuple(np.add(config.camera.target, (50, 0, 0)))))
    with pytest.raises(
        UserError, match="no Gaussian reaches perception's picture.*--azimuth and --elevation"
    ):
        check_first_picture(config.model_copy(update=dict(camera=aside)), body)
    behind = config.camera.model_copy(
        update=dict(target=tuple(np.add(config.camera.target, (0, 50, 0))), azimuth_degrees=0.0)
    )
    with pytest.raises(UserError, match="nearer to the camera than 0.01 m"):
        check_first_picture(config.model_copy(update=dict(camera=behind)), body)


def test_an_object_of_two_pixels_is_refused(tmp_path):
    """A body of 1 m at d m spans 1 / d of the focal length, which is 32 / tan(20 degrees) pixels."""
    config, body = make_ready(tmp_path, cloud_of(BALL, scale=1e-4))
    focal = 32 / math.tan(math.radians(20))
    for pixels in (20.0, 2.0):
        target = tuple(0.5 * (body.low + body.high))
        camera = config.camera.model_copy(update=dict(distance=focal / pixels, target=target))
        scene = config.model_copy(update=dict(camera=camera))
        assert measure_length(scene, body) == pytest.approx(pixels, rel=0.1)
        if pixels > 3:
            check_first_picture(scene, body)
            continue
        with pytest.raises(UserError, match=r"too small in perception's pictures.*64 x 64.*--resolution"):
            check_first_picture(scene, body)


def test_pictures_in_which_no_point_can_be_followed_are_warned_of(tmp_path):
    config, body = make_ready(tmp_path, cloud_of(POLE, scale=0.001), resolution=16)
    (note,) = check_first_picture(config, body)
    assert "of 256 pixels" in note and "turns or deforms" in note and "`overrides.width`" in note


def test_an_object_that_the_border_cuts_off_is_warned_of(tmp_path):
    (note,) = check_first_picture(*make_ready(tmp_path, cloud_of(BALL, scale=0.25)))
    assert "beyond the border" in note


@pytest.mark.parametrize(
    ("prompt", "found"),
    [
        (SegmentPrompt(points=np.array([[32.0, 32.0]])), True),
        (SegmentPrompt(points=np.array([[1.0, 1.0], [32.0, 32.0]])), True),
        (SegmentPrompt(box=np.array([20.0, 20.0, 60.0, 60.0])), True),
        (SegmentPrompt(mask=np.ones((64, 64), bool)), True),
        (SegmentPrompt(frame=3, points=np.array([[1.0, 1.0]])), True),  # nobody knows where it is by then
        (SegmentPrompt(points=np.array([[1.0, 1.0]])), False),
        (SegmentPrompt(points=np.array([[1.0, 1.0], [32.0, 32.0]]), labels=np.array([True, False])), False),
        (SegmentPrompt(box=np.array([0.0, 0.0, 4.0, 4.0])), False),
        (SegmentPrompt(mask=np.eye(64, dtype=bool) & (np.arange(64) < 4)), False),
    ],
)
def test_a_prompt_beside_the_object_is_refused(prompt, found, ball):
    config, body = ball
    if found:
        check_first_picture(config, body, prompt)
        return
    with pytest.raises(UserError, match="points at nothing in the first picture.*in shares of the picture"):
        check_first_picture(config, body, prompt)


def test_a_prompt_without_a_point_on_the_object_is_refused(ball):
    prompt = SegmentPrompt(points=np.array([[32.0, 32.0]]), labels=np.array([False]))
    with pytest.raises(UserError, match="no point of the prompt is on the object"):
        check_first_picture(*ball, prompt)


@pytest.mark.usefixtures("quick_plans")
def test_run_and_plan_refuse_before_anything_is_simulated(tmp_path, capsys):
    write_ply(tmp_path / "blob.ply", cloud_of(BALL, scale=0.42))
    line = [
        "--object",
        str(tmp_path / "blob.ply"),
        "--prompt",
        "twist it",
        "--out",
        str(tmp_path / "out"),
    ]
    assert main(["run", *line, "--particles", "600", "--frames", "8", "--resolution", "64"]) == 2
    said = capsys.readouterr().err
    assert "fills perception's picture" in said and "simulating" not in said and "Traceback" not in said
    assert not (tmp_path / "out").exists()
    assert main(["plan", "twist it", "--object", str(tmp_path / "blob.ply")]) == 2
    assert "fills perception's picture" in capsys.readouterr().err


def test_the_picture_is_that_of_frame_0(robot_path):
    """The picture drawn beforehand is the one that perception gets: the object at rest, to the pixel."""
    from physagent_jax.scene.compile import compile_scene
    from physagent_jax.simulation.simulate import simulate_scene

    run = resolve(small(robot_path, frames=2, world="free"))
    preset = run.template.preset
    body = make_body(run.template.source, preset.filling, preset.domain, run.base_dir)
    scene = compile_scene(fuse(run.template, body, ForceField()), body)
    image = draw_first_picture(scene.config, body)
    recording = simulate_scene(scene)
    np.testing.assert_allclose(np.asarray(image.depth), recording.depth[0], atol=1e-4)


def test_a_run_in_which_nothing_is_found_ends_with_a_report(robot_path, tmp_path):
    """The object is drawn, but this segmenter does not find it: FAIL, "not observable", and all files."""

    class Blind(Segmenter):
        def segment(self, frames, prompt, depth=None):
            return Masks(np.zeros(frames.shape[:3], bool))

    backends = dataclasses.replace(make_backends(), segmenter=Blind())
    spec = small(robot_path, frames=5, particles=300, resolution=48, rounds=1)
    store = made(spec, tmp_path / "run", backends=backends)
    assert store.manifest.verdict == "FAIL"
    report = store.read("iterations/0/motion_report.json", MotionReport)
    assert report is not None and set(report.centroid) == {None}
    assert "not in the picture" in store.read("iterations/0/judgement.json", Judgement).suggestion
    assert "not observable" in write_report(store.path).read_text()
