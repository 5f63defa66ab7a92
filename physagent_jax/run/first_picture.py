"""The first picture, drawn before anything is simulated: what perception could not measure from it is refused."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.covariance import quats_scales_to_covariances
from physagent_jax.perception.follow import FEWEST, place_seeds
from physagent_jax.perception.lift import keep_trusted_depth
from physagent_jax.perception.protocols import SegmentPrompt
from physagent_jax.perception.reasons import FILLING
from physagent_jax.perception.unobservable import (
    LEAST_PIXELS,
    explain_outline,
    measure_border_share,
    touches_border,
)
from physagent_jax.render import RenderedImage, render
from physagent_jax.render.project import ALPHA_MIN, NEAR_PLANE
from physagent_jax.scene.body import Body
from physagent_jax.scene.camera import find_view_direction, make_reference_camera
from physagent_jax.scene.compile import buckets
from physagent_jax.scene.config import SceneConfig

OPAQUE = 0.5
"""Coverage from which a pixel is the object's; a haze of faint Gaussians hides nothing."""
LEAST_LENGTH = 3.0
"""A shorter object is hidden by the blur with which its Gaussians are drawn [px]."""
PLAIN_SIZE, LARGEST_PLAIN = 0.06, 0.15
"""Sizes of which few Gaussians exceed the first and none the second where there is an outline [std over length]."""
PROMPT_OFF = 0.02
"""Largest distance from what is drawn at which a point of a prompt may lie [share of the picture's width]."""


def draw_first_picture(config: SceneConfig, body: Body) -> RenderedImage:
    """The object at rest as perception's camera sees it.

    Args:
        config: The scene, its camera placed.
        body: Its object.
    """
    cloud, _ = buckets.pad_gaussians(
        body.cloud.of_least_degree(), body.binding
    )  # the program of later frames
    splats = Splats(
        means=cloud.means,
        covariances=quats_scales_to_covariances(cloud.quats, cloud.scales),
        opacities=cloud.opacities,
        sh=cloud.sh,
        rotations=to_device(np.broadcast_to(body.placement.rotation, (cloud.count, 3, 3)), cloud.means.dtype),
    )
    camera = make_reference_camera(config.camera, config.rendering, config.domain)
    return render(splats, camera, background=config.rendering.background)


def is_in_doubt(body: Body) -> bool:
    """Return whether an object could fill the picture of its camera, or not show: found without a picture."""
    opacities, scales = np.asarray(body.cloud.opacities), np.asarray(body.cloud.scales)
    shown = opacities >= ALPHA_MIN
    if not shown.any():
        return True
    sizes = scales[shown].max(axis=1) / max(body.extent, 1e-12)
    return not (np.quantile(sizes, 0.95) <= PLAIN_SIZE and sizes.max() <= LARGEST_PLAIN)


def measure_length(config: SceneConfig, body: Body) -> float:
    """Longer side of the object's box in perception's picture, from centres and typical sizes of its Gaussians [px]."""
    camera = make_reference_camera(config.camera, config.rendering, config.domain)
    seen = np.asarray(body.cloud.means, np.float64) @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
    shown = (seen[:, 2] > NEAR_PLANE) & (np.asarray(body.cloud.opacities) >= ALPHA_MIN)
    if not shown.any():
        return 0.0
    places = (seen[shown] @ camera.K.T)[:, :2] / seen[shown, 2:]
    deviation = np.median(np.asarray(body.cloud.scales)[shown].max(1) / seen[shown, 2]) * camera.K[0, 0]
    return float(np.ptp(places, axis=0).max() + 4 * deviation)


def check_first_picture(
    config: SceneConfig, body: Body, prompt: SegmentPrompt | None = None
) -> tuple[str, ...]:
    """Refuse a scene whose first picture shows too little of the object, or nothing but the object.

    Only what no segmenter and no tracker could measure is refused. What happens to the object later is not known yet.

    Args:
        config: The scene, its camera placed.
        body: Its object.
        prompt: Which object is meant, in these pictures; None = the only one.

    Returns:
        Warnings, a sentence each.

    Raises:
        UserError: Nothing can be measured; the message says how many pixels show the object, and which option helps.
    """
    if prompt is not None:
        prompt.check_fit((config.timing.frame_count, config.rendering.height, config.rendering.width))
    image = draw_first_picture(config, body)
    alpha, depth = np.asarray(image.alpha), np.asarray(image.depth)
    drawn, solid = alpha > 0, alpha >= OPAQUE
    if not drawn.any():
        _refuse_unseen(config, body)
    length = measure_length(config, body)
    if drawn.sum() < LEAST_PIXELS or length < LEAST_LENGTH:
        raise UserError(
            "the motion could not be measured: the object is too small in perception's pictures, "
            f"{LEAST_LENGTH:g} pixels are the least length",
            got=f"{length:.2g} pixels, in pictures of {drawn.shape[1]} x {drawn.shape[0]}",
            do="Raise --resolution",
        )
    if explain_outline(solid) == FILLING:
        _refuse_filling(solid, body)
    if prompt is not None:
        _check_prompt(prompt, drawn)
    return _find_weaknesses(solid if solid.sum() >= LEAST_PIXELS else drawn, depth)


def _find_weaknesses(mask: np.ndarray, depth: np.ndarray) -> tuple[str, ...]:
    """Warnings of what can be measured in part; ``mask`` is the object, ``depth`` its depth [m], shape (H, W)."""
    notes = []
    if touches_border(mask):
        notes.append(
            "the object reaches beyond the border of perception's picture, and body lengths are those of the part that "
            "shows; its Gaussians may be too large for it"
        )
    trusted = keep_trusted_depth(np.where(mask, depth, np.nan), mask)[0]
    seeds, _ = place_seeds(np.zeros((*mask.shape, 3), np.uint8), trusted)
    if len(seeds) < FEWEST:
        notes.append(
            f"the object covers {mask.sum()} of {mask.size} pixels of perception's pictures: too few points can be "
            "followed to tell how it turns or deforms; raise `overrides.width`"
        )
    return tuple(notes)


def _refuse_unseen(config: SceneConfig, body: Body) -> None:
    opacity = float(np.max(np.asarray(body.cloud.opacities), initial=0.0))
    if opacity < ALPHA_MIN:
        raise UserError(
            f"nothing of the object would be seen: all its Gaussians are fainter than {ALPHA_MIN:.4f}, the least that "
            "is drawn",
            got=f"{opacity:.2g} at most",
            do="See whether the file's opacities are logits; --opacity-threshold 0.02 leaves out what is so faint",
        )
    camera, forward = config.camera, find_view_direction(config.camera)
    assert camera.target is not None
    depths = (np.asarray(body.cloud.means, np.float64) - camera.target) @ forward + camera.distance
    if depths.max() < NEAR_PLANE:
        raise UserError(
            f"nothing of the object would be seen: it is nearer to the camera than {NEAR_PLANE:g} m",
            got=f"{max(float(depths.max()), 0):.2g} m for an object of {body.extent:.2g} m",
            do="Make it larger: `object.extent`",
        )
    raise UserError(
        "nothing of the object would be seen: no Gaussian reaches perception's picture",
        got=f"a camera at azimuth {camera.azimuth_degrees:g}, elevation {camera.elevation_degrees:g} degrees",
        do="Look from elsewhere with --azimuth and --elevation",
    )


def _refuse_filling(solid: np.ndarray, body: Body) -> None:
    length = float(np.median(np.asarray(body.cloud.scales).max(axis=1))) / max(body.extent, 1e-12)
    raise UserError(
        "the motion could not be measured: the object fills perception's picture, so that neither its size nor its "
        f"outline shows. Half of its Gaussians have a standard deviation of {length:.2g} of the object's size or more",
        got=f"{measure_border_share(solid):.0%} of the border, {solid.mean():.0%} of all pixels",
        do="See whether the file's scales are logarithms, or leave out the faint Gaussians (--opacity-threshold)",
    )


def _check_prompt(prompt: SegmentPrompt, drawn: np.ndarray) -> None:
    """Refuse a prompt for the first picture that nothing of the object is at."""
    if prompt.frame > 0:
        return
    height, width = drawn.shape
    y, x = np.nonzero(drawn)
    meant = False if prompt.mask is None else bool((np.asarray(prompt.mask, bool) & drawn).any())
    if prompt.points is not None:
        labels = (
            np.ones(len(prompt.points), bool) if prompt.labels is None else np.asarray(prompt.labels, bool)
        )
        for px, py in np.asarray(prompt.points, float)[labels]:
            meant |= bool(np.hypot(x + 0.5 - px, y + 0.5 - py).min() <= max(PROMPT_OFF * width, 2.0))
    if prompt.box is not None:
        x0, y0, x1, y1 = prompt.box
        meant |= bool(((x + 1 > x0) & (x < x1) & (y + 1 > y0) & (y < y1)).any())
    if not meant:
        raise UserError(
            "`perception.prompt` points at nothing in the first picture",
            got=f"the object is at x {x.min() / width:.2f} to {(x.max() + 1) / width:.2f}, "
            f"y {y.min() / height:.2f} to {(y.max() + 1) / height:.2f}, in shares of the picture",
            do="Place the points, the box or the mask on it",
        )
