"""The README's pictures: four sentences, each run through the closed loop, as a GIF and as a strip of frames.

Run: python examples/make_pictures.py               # small and coarse, into ./pictures: a minute
     python examples/make_pictures.py docs/images   # the README's own, with the default settings: some minutes
"""

import sys
import tempfile
from pathlib import Path

import cv2
import imageio.v3 as iio
import numpy as np

import physagent_jax as pa
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.procedural import PROCEDURAL

ROBOT = Path(__file__).parent / "assets" / "robot.ply"
SENTENCES = {
    "plant": "a strong wind bends the plant to the left, then lets go",
    "jelly": "drop the jelly",
    "loaf": "someone presses down on the middle of the loaf and lets go",
    "robot": "spin the robot clockwise",
}
SMALL = dict(
    rounds=1,
    overrides=dict(frame_count=12, max_particles=1500, width=160, height=120),
    save=dict(video_size=(320, 180)),
)
GIF_WIDTH, STRIP_WIDTH = 320, 240  # [px], of a frame
MOST_BYTES = 1_500_000
LONG = 100  # frames from which every other one is shown, for twice as long


def film(name, prompt, folder, settings):
    """The frames that a run leaves, uint8, shape (T, height, width, 3), and its verdict."""
    path = ROBOT
    if name in PROCEDURAL:  # as `physagent make` does
        path = folder / f"{name}.ply"
        write_ply(path, PROCEDURAL[name](0))
    chosen = dict(path=str(path), up=None if path == ROBOT else "+z")
    spec = pa.RunSpec.model_validate(dict(object=chosen, prompt=prompt, **settings))
    run = pa.synthesize(spec, folder / name)
    return run.frames(), run.manifest.verdict


def resize(frames, width):
    """Frames of another width, 16:9."""
    size = (width, width * 9 // 16)
    return np.stack([cv2.resize(frame, size, interpolation=cv2.INTER_AREA) for frame in frames])


def main(out, settings):
    """Write a GIF per sentence, and one picture with five frames of each."""
    out.mkdir(parents=True, exist_ok=True)
    strips = []
    for name, prompt in SENTENCES.items():
        with tempfile.TemporaryDirectory() as folder:
            frames, verdict = film(name, prompt, Path(folder), settings)
        path = out / f"{name}.gif"
        step = 1 + len(frames) // LONG
        iio.imwrite(path, resize(frames[::step], GIF_WIDTH), plugin="pillow", duration=40 * step, loop=0)
        chosen = np.linspace(0, len(frames) - 1, 5).round().astype(int)
        strips.append(np.concatenate(list(resize(frames[chosen], STRIP_WIDTH)), axis=1))
        print(f"{path}: {prompt!r}, {verdict}, {path.stat().st_size / 1e3:.0f} kB")
        assert np.ptp(frames.astype(int), axis=0).max() > 100 and path.stat().st_size < MOST_BYTES
        assert iio.immeta(path)["duration"] == 40 * step and len(iio.imread(path)) == len(frames[::step])
    iio.imwrite(out / "frames.png", np.concatenate(strips))
    print(out / "frames.png")


if __name__ == "__main__":
    pa.enable_compile_cache()
    given = sys.argv[1:]
    main(Path(given[0]), {}) if given else main(Path("pictures"), SMALL)
