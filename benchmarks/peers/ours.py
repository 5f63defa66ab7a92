"""Our own simulator behind the `Peer` interface, so that it runs a scene as the others do."""

from __future__ import annotations

import math
import time
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.peers.drop import FRAME_DT
from benchmarks.peers.scene import Material, PeerScene
from physagent_jax.kernels import describe_kernels
from physagent_jax.mpm import Contact, DomainBox, HalfSpace, Model, State, cell_order, lame_parameters
from physagent_jax.mpm import materials as laws
from physagent_jax.mpm.frame import advance, measure_extent
from physagent_jax.mpm.health import Health
from physagent_jax.mpm.materials.von_mises import yield_stress_from_deviator_norm
from physagent_jax.mpm.window import find_smallest_window, fit_window


class Ours:
    """Runs a `PeerScene` with physagent_jax, the grid window following the particles as `mpm.simulate` has it.

    Args:
        kernels: As in `Model`.
        sort: Whether `load` sorts the particles, as compiling a scene does.
    """

    name = "ours"

    def __init__(self, kernels: Any = "auto", sort: bool = True):
        self.kernels, self.sort = kernels, sort
        self.compile_seconds = 0.0  # spent within `run`, because the window grew

    def available(self) -> str | None:
        """Always None."""
        return None

    def version(self) -> str:
        """JAX's version, the device and the kernels."""
        return f"jax {jax.__version__} on {jax.default_backend()}, kernels {describe_kernels(self.kernels)}"

    def load(self, scene: PeerScene, dt: float, granule: int = 0) -> None:
        """Build model and state, and compile for the first window."""
        order = cell_order(scene.x, scene.dx) if self.sort else np.arange(scene.particle_count)
        self._back = np.argsort(order)
        model, self.state = build(scene.take(order), self.kernels)
        self._dt = dt
        self.model = model.replace(dt=jnp.asarray(dt, jnp.float32))
        self.compile_seconds = 0.0
        self._fit_window(FRAME_DT)
        jax.block_until_ready(advance(self.model, self.state, jnp.int32(1)))

    def run(self, steps: int) -> None:
        """Advance by ``steps`` substeps, in frames of at most FRAME_DT.

        Raises:
            RuntimeError: `mpm.simulate` would redo a frame.
        """
        frame = max(1, round(FRAME_DT / self._dt))
        while steps > 0:
            chunk = min(steps, frame)
            self._fit_window(chunk * self._dt)
            self.state, health, _ = advance(self.model, self.state, jnp.int32(chunk))
            if not _judge(health, self.model):
                raise RuntimeError(f"the frame cannot be trusted: {health}")
            steps -= chunk

    def x(self) -> np.ndarray:
        """Positions [m], shape (n, 3)."""
        return np.asarray(self.state.x)[self._back]

    def v(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        return np.asarray(self.state.v)[self._back]

    def F(self) -> np.ndarray:
        """Elastic deformation gradients, shape (n, 3, 3)."""
        return np.asarray(self.state.F)[self._back]

    def _fit_window(self, duration: float) -> None:
        """The window for the coming ``duration`` [s]; where its shape changes, compilation is timed apart."""
        shape = self.model.grid.shape
        low, high, speed = jax.device_get(measure_extent(self.state.x, self.state.v))
        reach = float(speed) * duration + 2 * self.model.grid.dx
        grid = fit_window(self.model.grid, low, high, reach)
        self.model = self.model.replace(grid=grid)
        if grid.shape != shape:
            begun = time.perf_counter()
            jax.block_until_ready(advance(self.model, self.state, jnp.int32(0)))
            self.compile_seconds += time.perf_counter() - begun


_judge = jax.jit(Health.is_good)


def build(scene: PeerScene, kernels: Any = "auto") -> tuple[Model, State]:
    """``scene`` in our terms and the precision of its positions, with the smallest window and no step yet.

    Raises:
        NotImplementedError: The transfer has no counterpart with these options.
    """
    own = lambda values: jnp.asarray(values, scene.x.dtype)  # noqa: E731
    material = _make_law(scene, own)
    planes = [
        HalfSpace(
            point=own(plane.point),
            normal=own(plane.unit_normal()),
            friction=own(plane.friction),
            start=own(-math.inf),
            end=own(math.inf),
            contact=Contact(plane.contact.value),
        )
        for plane in scene.planes
    ]
    walls = [] if scene.domain_box is None else [DomainBox(scene.domain_box)]
    model = Model(
        grid=find_smallest_window(scene.size, scene.cells),
        dt=own(0),
        gravity=own(scene.gravity),
        mass=own(scene.mass),
        volume=own(scene.volume),
        materials=(material,),
        boundaries=(*planes, *walls),
        transfer=scene.transfer,
        rpic_damping=scene.rpic_damping,
        kernels=kernels,
    )
    state = State.at_rest(own(scene.x), own(scene.v), materials=(material,))
    return model, state.__class__(**(vars(state) | {"C": own(scene.C)}))


def _make_law(scene: PeerScene, own: Any) -> Any:
    mu, lam = (own(values) for values in lame_parameters(scene.youngs_modulus, scene.poissons_ratio))
    match scene.material:
        case Material.NEO_HOOKEAN:
            return laws.NeoHookean(mu, lam)
        case Material.JELLY:
            return laws.FixedCorotated(mu, lam)
        case Material.METAL:
            bound = own(yield_stress_from_deviator_norm(scene.yield_stress))
            return laws.VonMises(mu, lam, bound, jnp.zeros_like(bound))
        case Material.SAND:
            angle = jnp.full_like(mu, math.radians(scene.friction_angle_degrees))
            return laws.DruckerPrager(mu, lam, angle, jnp.zeros_like(mu))
        case Material.FLUID:
            return laws.Fluid(own(scene.bulk_modulus), tension=True)
