"""A picture of an object at rest from four sides, by which a person tells whether it stands the right way up."""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path

import cv2
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import check_writable, write_bytes
from physagent_jax.gaussians.cloud import GaussianCloud, Splats
from physagent_jax.gaussians.covariance import quats_scales_to_covariances
from physagent_jax.output.video import encode_png
from physagent_jax.render import render
from physagent_jax.render.camera import Camera
from physagent_jax.render.stage import Stage, compose, make_backdrop
from physagent_jax.run.part_marks import place_numbers, tint
from physagent_jax.scene.camera import frame_camera, make_reference_camera
from physagent_jax.scene.compile.buckets import pad_cloud
from physagent_jax.scene.config import CameraConfig, Domain, Rendering
from physagent_jax.scene.placement import Placement

SIDES = (("front", 0.0), ("right", 90.0), ("back", 180.0), ("left", -90.0))
"""The views' names and azimuths from the front [degrees], two in a row."""
WIDTH, HEIGHT = 480, 360  # of a view [px]
TRIMMED = 2e-3  # share of the Gaussians on each side that need not be in the picture
MOST_POINTS = 20_000  # that are framed
REACH = 2.0  # standard deviations to which a Gaussian is seen
INK, AXIS_COLOURS = (40, 40, 45), ((205, 40, 40), (30, 130, 50), (40, 70, 210))  # RGB; of x, y and z
PALE = (245, 245, 245)
ARROW, AXIS = 60, 34  # lengths of the arrow of up and of the file's axes [px]
MARK = b"Software\0physagent inspect"
"""The text by which a preview is told from pictures that somebody else made."""


def draw_preview(
    cloud: GaussianCloud,
    placement: Placement,
    camera: CameraConfig,
    domain: Domain,
    up: str,
    owner: np.ndarray | None = None,
) -> np.ndarray:
    """Draw an object on the ground from its front, right, back and left.

    Args:
        cloud: The object's Gaussians in the world [m].
        placement: From the file's frame to the world.
        camera: The direction from which the front is seen; where it stands follows from the object.
        domain: The domain that the object is placed in.
        up: The label of the arrow that points up.
        owner: The part of each Gaussian, which gets its colour and number; -1 = none, shape (g,); None = no parts.

    Returns:
        The picture, uint8, shape (2 `HEIGHT`, 2 `WIDTH`, 3).

    Raises:
        UserError: A view does not fit into memory.
    """
    if owner is not None:
        cloud = tint(cloud, owner)
    points, low, high = _choose_points(cloud)
    stage = Stage(float(low[2]), max(float((high - low).max()), 1e-6))
    splats, rendering = _make_splats(cloud, placement.rotation), Rendering(width=WIDTH, height=HEIGHT)
    azimuths = {name: 180 - (180 - camera.azimuth_degrees - turn) % 360 for name, turn in SIDES}
    placed = [
        frame_camera(points, camera.model_copy(update=dict(azimuth_degrees=each, target=None)), rendering)
        for each in azimuths.values()
    ]
    distance = max(each.distance for each in placed)  # the same for all, so that sizes can be compared
    views = []
    for (name, azimuth), each in zip(azimuths.items(), placed):
        seen = make_reference_camera(each.model_copy(update=dict(distance=distance)), rendering, domain)
        image = render(splats, seen, background=(0.0, 0.0, 0.0))
        picture = compose(image, splats, make_backdrop(stage, seen))
        if owner is not None:
            centres = np.asarray(cloud.means, np.float64)
            for index, at in place_numbers(seen, np.asarray(image.depth), centres, owner):
                _write(picture, str(index + 1), (at[0] - 5, at[1] + 5))
        _write(picture, f"{name} (--azimuth {azimuth:g})", (12, 24))
        _draw_up(picture, up)
        _draw_axes(picture, seen, placement.rotation)
        picture[[0, -1]], picture[:, [0, -1]] = PALE, PALE  # a line between the views
        views.append(picture)
    return np.concatenate([np.concatenate(views[:2], axis=1), np.concatenate(views[2:], axis=1)], axis=0)


def check_preview(path: Path, *, overwrite: bool = False) -> None:
    """Refuse a place for a preview before any work is done for it.

    Raises:
        UserError: The file is no .png, another file is there, or the folder cannot be written to.
    """
    if path.suffix.lower() != ".png":
        raise UserError("a preview is a .png file", got=str(path), do="Pass --out preview.png")
    check_writable(path.parent)
    if os.path.lexists(path) and not overwrite and not is_preview(path):
        raise UserError(
            f"{path} exists and is no preview", do="Choose another --out, or pass --overwrite to replace it"
        )


def write_preview(path: Path, picture: np.ndarray, *, overwrite: bool = False) -> None:
    """Write a preview as PNG with a mark in it; an earlier preview is replaced, any other file is not.

    Args:
        path: The file to write.
        picture: Shape (h, w, 3), uint8.
        overwrite: Replace whatever is there.

    Raises:
        UserError: As `check_preview`, or the file cannot be written.
    """
    check_preview(path, overwrite=overwrite)
    write_bytes(path, _add_mark(encode_png(picture)))


def is_preview(path: Path) -> bool:
    """Return whether a file is a picture that `write_preview` has written."""
    try:
        with path.open("rb") as file:
            return MARK in file.read(256)
    except OSError:
        return False


def _choose_points(cloud: GaussianCloud) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points that are framed, shape (m, 3), and the corners of their bounding box, shapes (3,) [m].

    They lie as far outside of the centres as most Gaussians reach.
    """
    points = np.asarray(cloud.means, np.float64)
    low, high = np.quantile(points, [TRIMMED, 1 - TRIMMED], axis=0)
    points = np.clip(points[:: -(-len(points) // MOST_POINTS)], low, high)
    reach = REACH * float(np.median(np.asarray(cloud.scales, np.float64).max(axis=1)))
    return points + reach * np.sign(points - 0.5 * (low + high)), low, high


def _make_splats(cloud: GaussianCloud, rotation: np.ndarray) -> Splats:
    """The Gaussians at rest, filled up so that objects of about the same size are drawn by the same program."""
    filled = pad_cloud(cloud.of_least_degree())
    return Splats(
        means=filled.means,
        covariances=quats_scales_to_covariances(filled.quats, filled.scales),
        opacities=filled.opacities,
        sh=filled.sh,
        rotations=jnp.broadcast_to(jnp.asarray(rotation, jnp.float32), (filled.count, 3, 3)),
    )


def _draw_up(picture: np.ndarray, up: str) -> None:
    """Draw an upward arrow into the upper right corner, with its label to the left."""
    x = WIDTH - 28
    cv2.arrowedLine(picture, (x, 14 + ARROW), (x, 14), INK, 2, cv2.LINE_AA, tipLength=0.22)
    _write(picture, up, (x - 12 - 9 * len(up), 28))


def _draw_axes(picture: np.ndarray, camera: Camera, rotation: np.ndarray) -> None:
    """Draw the file's axes as seen from the camera into the lower left corner, the farthest first."""
    axes = np.asarray(camera.viewmat, np.float64)[:3, :3] @ rotation  # columns: the file's x, y, z
    origin = (54, HEIGHT - 60)
    for index in np.argsort(-axes[2]):
        (x, y), (dx, dy) = origin, axes[:2, index]
        tip = round(x + AXIS * dx), round(y + AXIS * dy)
        cv2.arrowedLine(picture, origin, tip, AXIS_COLOURS[index], 2, cv2.LINE_AA, tipLength=0.25)
        beyond = round(x - 4 + (AXIS + 10) * dx), round(y + 4 + (AXIS + 10) * dy)
        _write(picture, "xyz"[index], beyond, AXIS_COLOURS[index])


def _write(picture: np.ndarray, text: str, at: tuple[int, int], colour: tuple[int, int, int] = INK) -> None:
    """Write ASCII text with its lower left corner ``at`` (x, y) [px], with a pale rim that sets it off."""
    rim = [(dx, dy, PALE) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy]
    for dx, dy, ink in [*rim, (0, 0, colour)]:
        cv2.putText(
            picture, text, (at[0] + dx, at[1] + dy), cv2.FONT_HERSHEY_SIMPLEX, 0.5, ink, 1, cv2.LINE_AA
        )


def _add_mark(png: bytes) -> bytes:
    """A PNG with `MARK` as a text chunk behind its header (PNG specification, 11.3.4.3)."""
    end = 8 + 4 + 4 + 13 + 4  # signature; length, type, data and checksum of IHDR
    chunk = b"tEXt" + MARK
    text = struct.pack(">I", len(MARK)) + chunk + struct.pack(">I", zlib.crc32(chunk))
    return png[:end] + text + png[end:]
