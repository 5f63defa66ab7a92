"""Notes over a video, on request: the sentence, and arrows where something acts."""

from __future__ import annotations

import numpy as np

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import Action, VelocityConstraint
from physagent_jax.render.camera import Camera
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import SceneConfig

LENGTH = 0.4  # [sizes] of the arrow of M = 1
SUDDEN = 0.3  # [s] for which the arrow of a blow is seen
INK, HALO = (214, 72, 38), (255, 255, 255)  # RGB
LINE_SHARE = 0.045  # of the picture's height that a line of text takes


def write_caption(picture: np.ndarray, text: str) -> np.ndarray:
    """The picture with ``text`` on a dark band at its lower edge, as many lines as it takes."""
    import cv2

    height, width = picture.shape[:2]
    size = LINE_SHARE * height / 30
    thickness = max(1, round(2 * size))
    font = cv2.FONT_HERSHEY_SIMPLEX

    def measure(line: str) -> int:
        return cv2.getTextSize(line, font, size, thickness)[0][0]

    lines: list[str] = []
    for word in text.encode("ascii", "replace").decode().split():
        if lines and measure(f"{lines[-1]} {word}") <= 0.92 * width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    step = round(1.35 * LINE_SHARE * height)
    top = max(height - step * len(lines) - step // 2, 0)
    out = picture.copy()
    out[top:] = (0.42 * out[top:]).astype(np.uint8)
    for index, line in enumerate(lines):
        at = ((width - measure(line)) // 2, top + step * (index + 1))
        cv2.putText(out, line, at, font, size, (255, 255, 255), thickness, cv2.LINE_AA)
    return out


def find_arrows(config: SceneConfig, body: Body, x: np.ndarray, index: int) -> list[np.ndarray]:
    """Polylines [m], shape (k, 3), each with its head at the end, for what acts in a frame.

    Args:
        config: The scene.
        body: Its object.
        x: Positions of its particles in that frame [m], shape (n, 3).
        index: Number of the frame.
    """
    found: list[np.ndarray] = []
    for item in (*config.force_field.actions, *config.force_field.constraints):
        first, last = item.active_time or (0, config.timing.frame_count - 1)
        if _is_sudden(item):
            last = first + SUDDEN / config.timing.frame_dt
        if not first <= index <= last:
            continue
        chosen = x
        if item.region is not None:
            chosen = x[np.asarray(make_region_mask(item.region, np.asarray(body.particles.x), "region"))]
        found += _draw_item(item, chosen, body.extent)
    return found


def _is_sudden(item: Action | VelocityConstraint) -> bool:
    """Return whether a skill acts at once, so that its window tells only when."""
    kind = item.action_type if isinstance(item, Action) else item.constraint_type
    return kind.skill.is_sudden


def draw_arrows(picture: np.ndarray, arrows: list[np.ndarray], camera: Camera) -> np.ndarray:
    """The picture with ``arrows`` (as `find_arrows` gives them) drawn over it."""
    import cv2

    out = picture.copy()
    width = max(2, round(camera.height / 120))
    for colour, more in ((HALO, 2), (INK, 0)):
        for line in arrows:
            local = line @ np.asarray(camera.viewmat, np.float64)[:3, :3].T + camera.viewmat[:3, 3]
            if (local[:, 2] <= 1e-3).any():
                continue
            pixels = local @ np.asarray(camera.K, np.float64).T
            places = np.rint(pixels[:, :2] / pixels[:, 2:]).astype(int)
            if np.abs(places).max() > 20_000:
                continue
            cv2.polylines(out, [places[:-1].reshape(-1, 1, 2)], False, colour, width + more, cv2.LINE_AA)
            head = 4.0 * width / max(float(np.linalg.norm(places[-1] - places[-2])), 1.0)
            ends = [tuple(each.tolist()) for each in places[-2:]]
            cv2.arrowedLine(
                out, ends[0], ends[1], colour, width + more, cv2.LINE_AA, tipLength=min(head, 1.0)
            )
    return out


def _draw_item(item: Action | VelocityConstraint, x: np.ndarray, size: float) -> list[np.ndarray]:
    kind = str(item.action_type if isinstance(item, Action) else item.constraint_type)
    vector, centre = np.asarray(item.vector, np.float64), np.median(x, axis=0)
    sign, length = np.sign(item.magnitude), LENGTH * size * abs(item.magnitude)
    if "torque" in kind or "rotation" in kind or "twist" in kind or "wring" in kind:
        aside = np.cross(vector, [0, 0, 1] if abs(vector[2]) < 0.9 else [1, 0, 0])
        aside /= np.linalg.norm(aside)
        angles = sign * np.linspace(0, 1.5 * np.pi, 25)[:, None]
        radius = 0.45 * size
        return [centre + radius * (np.cos(angles) * aside + np.sin(angles) * np.cross(vector, aside))]
    along = (x - centre) @ vector
    low, high = np.quantile(along, [0.01, 0.99])
    if "scale" in kind or "stretch" in kind or "squeeze" in kind:
        out = [(high, vector), (-low, -vector)]
        step = 0.5 * length
        return [
            np.stack([centre + reach * way, centre + (reach + step) * way][:: 1 if sign > 0 else -1])
            for reach, way in out
        ]
    way = sign * vector
    back = -low if sign > 0 else high  # the arrow ends where it meets the object
    return [np.stack([centre - (back + length) * way, centre - back * way])]
