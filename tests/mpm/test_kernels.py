"""The CPU kernels against the reference that they stand for, and what decides between the two."""

import dataclasses
import logging
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import physagent_jax.kernels as choice
from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import Grid, kernels, materials, rollout, simulate, transfer
from physagent_jax.mpm.linalg import isotropic, svd
from physagent_jax.mpm.linalg.kernels import load_cpu_kernels
from physagent_jax.mpm.linalg.svd import SWEEPS
from tests.mpm.blocks import block

pytest.importorskip("numba")
# The kernels are what runs long; what XLA compiles around them, and the references, is small.
pytestmark = pytest.mark.usefixtures("least_optimised")
cpu, svd_kernels = kernels.load_cpu_kernels(), load_cpu_kernels()


@pytest.fixture(autouse=True)
def on_the_cpu():
    """Compute where these kernels are, whatever else there is."""
    with jax.default_device(None if jax.default_backend() == "cpu" else jax.devices("cpu")[0]):
        yield


TOLERANCE = {"float32": 1e-5, "float64": 1e-13}  # round-off of sums in another order
GRID = Grid(jnp.array([3, 4, 5], jnp.int32), (12, 9, 14), 0.05, 60)


def cloud(count, dtype=np.float64, seed=0):
    """Particles in `GRID`, with F, C and stress of all kinds."""
    rng = np.random.default_rng(seed)
    low = (np.asarray(GRID.origin) + 1) * GRID.dx
    x = low + rng.uniform(size=(count, 3)) * (np.array(GRID.shape) - 4) * GRID.dx
    tau = 1e3 * rng.normal(size=(count, 3, 3))
    arrays = dict(
        x=x,
        v=rng.normal(size=(count, 3)),
        C=rng.normal(size=(count, 3, 3)),
        tau=tau + tau.swapaxes(1, 2),
        mass=rng.uniform(1, 2, count),
        volume=rng.uniform(1e-3, 2e-3, count),
        F=np.eye(3) + 0.1 * rng.normal(size=(count, 3, 3)),
        velocity=rng.normal(size=(*GRID.shape, 3)),
    )
    return {name: jnp.asarray(array, dtype) for name, array in arrays.items()}


def close(got, expected, tolerance):
    got, expected = np.asarray(got), np.asarray(expected)
    np.testing.assert_allclose(got, expected, atol=tolerance * np.abs(expected).max())


def p2g_operands(c):
    dv, dt = jnp.asarray([0.3, -0.2, 0.1], c["x"].dtype), jnp.asarray(1e-3, c["x"].dtype)
    return c["x"], c["v"], c["C"], c["tau"], c["mass"], c["volume"], dv, dt


def g2p_operands(c):
    return c["x"], c["v"], c["C"], c["F"], c["velocity"], jnp.asarray(1e-3, c["x"].dtype)


@pytest.mark.parametrize("form", ["mls", "gradient"])
@pytest.mark.parametrize("count", [1, 7, 3001])
def test_p2g_and_g2p_equal_the_reference(count, form, x64):
    """In both precisions, the reference in double."""
    c = cloud(count)
    nodes = jax.jit(partial(transfer.p2g, form, GRID))(*p2g_operands(c))
    moved = jax.jit(partial(transfer.g2p, form, 1, GRID))(*g2p_operands(c))
    for dtype, tolerance in TOLERANCE.items():
        c = cloud(count, dtype)
        close(jax.jit(partial(cpu.p2g, form, GRID))(*p2g_operands(c)), nodes, tolerance)
        got = jax.jit(partial(cpu.g2p, form, 1, GRID))(*g2p_operands(c))
        jax.tree.map(lambda a, b: close(a, b, tolerance), got, moved)  # noqa: B023


@partial(jax.jit, static_argnums=(0, 2))  # operation by operation, hundreds of programs are compiled
def pull(function, operands, seed=1):
    """Derivatives by the operands of a random sum of what a function gives."""
    results, back = jax.vjp(function, *operands)
    rng = np.random.default_rng(seed)
    return back(jax.tree.map(lambda leaf: jnp.asarray(rng.normal(size=leaf.shape), leaf.dtype), results))


def pulls_equal(kernel, reference, operands, seed=1):
    """`pull` of a kernel in both precisions against that of the reference in double precision."""
    expected = pull(reference, operands, seed)
    for dtype, tolerance in TOLERANCE.items():
        got = pull(kernel, [operand.astype(dtype) for operand in operands], seed)
        for each, other in zip(got, expected, strict=True):
            assert each.dtype == dtype
            close(each, other, tolerance)


@pytest.mark.parametrize("form", ["mls", "gradient"])
@pytest.mark.parametrize("count", [1, 7, 3001])
def test_adjoints_equal_the_derivatives_of_the_reference(count, form, x64):
    """By every operand, the step and the shared velocity change among them, particles in no order."""

    def moved(g2p):
        def particles(*o):
            after = g2p(form, 1, GRID, *o)
            return after.x, after.v, after.C, after.F

        return particles

    def scattered(p2g):
        return partial(p2g, form, GRID)

    pulls_equal(scattered(cpu.p2g), scattered(transfer.p2g), p2g_operands(cloud(count)))
    pulls_equal(moved(cpu.g2p), moved(transfer.g2p), g2p_operands(cloud(count)))


@pytest.mark.parametrize("form", ["mls", "gradient"])
def test_the_adjoint_with_a_neo_hookean_stress_equals_the_reference(form, x64):
    """Derivatives by x and F that come from what goes on with them are added to its own."""
    c, rng = cloud(3001), np.random.default_rng(2)
    x, v, C, _, *rest = p2g_operands(c)
    mu, lam = (jnp.asarray(rng.uniform(1e3, 2e3, 3001)) for _ in range(2))

    def reference(x, v, C, F, mu, lam, *rest):
        return transfer.p2g(form, GRID, x, v, C, materials.NeoHookean(mu, lam).stress(F), *rest), x, F

    pulls_equal(partial(cpu.p2g_neo_hookean, form, GRID), reference, (x, v, C, c["F"], mu, lam, *rest))


@pytest.mark.parametrize("form", ["mls", "gradient"])
def test_p2g_with_viscosity_and_its_adjoint_equal_the_reference(form, x64):
    """The stress of a viscous neo-Hookean body, made on the way; the rate of strain is not the C that is carried."""
    c, rng = cloud(3001), np.random.default_rng(2)
    x, v, C, _, *rest = p2g_operands(c)
    mu, lam, viscosity = (jnp.asarray(rng.uniform(1e3, 2e3, 3001)) for _ in range(3))
    rate = jnp.asarray(rng.normal(size=(3001, 3, 3)))
    operands = x, v, C, c["F"], mu, lam, viscosity, rate, *rest

    def reference(x, v, C, F, mu, lam, viscosity, rate, *rest):
        tau = materials.NeoHookean(mu, lam).stress(F) + materials.viscous_stress(viscosity, rate, F)
        return transfer.p2g(form, GRID, x, v, C, tau, *rest)

    kernel, expected = partial(cpu.p2g_kelvin_voigt, form, GRID), jax.jit(reference)(*operands)
    for dtype, tolerance in TOLERANCE.items():
        close(jax.jit(kernel)(*(o.astype(dtype) for o in operands)), expected, tolerance)
    pulls_equal(kernel, reference, operands)


def test_the_adjoint_of_node_velocities_equals_the_reference(x64):
    """Of full nodes, of empty ones and of those so light that they count as empty; planes of any size."""
    rng = np.random.default_rng(3)
    for shape in [(12, 9, 14), (3, 3, 3), (1, 5, 7)]:
        nodes = rng.normal(size=(*shape, 4))
        nodes[..., 3] = rng.choice([0.0, 1e-9, 0.5, 2.0], size=shape)
        operands = jnp.asarray(nodes), jnp.asarray(1e-6)
        pulls_equal(cpu.grid_velocity, lambda n, least: transfer.grid_velocity(n, least), operands)
        assert not pull(cpu.grid_velocity, operands)[0][nodes[..., 3] < 1e-6].any()


@pytest.mark.parametrize("form", ["mls", "gradient"])
@pytest.mark.parametrize("wall", [0, 6])
def test_the_adjoint_of_a_stop_at_walls_equals_the_reference(wall, form, x64):
    """With nobody behind the walls, and with many: who it was is found by G2P once more."""
    c = cloud(3001)
    operands = c["x"], c["F"], c["velocity"], jnp.asarray(1e-3)

    def kernel(x, F, velocity, dt):
        moved = cpu.g2p(form, wall, GRID, x, x, F, F, velocity, dt)
        return cpu.stop(form, wall, GRID, x, F, velocity, dt, moved.x, moved.v, moved.health.beyond)

    def reference(x, F, velocity, dt):
        moved = transfer.g2p(form, wall, GRID, x, x, F, F, velocity, dt)
        return transfer.stop(*transfer.find_walls(wall, GRID), moved.x, moved.v, moved.health.beyond)

    gather = jax.jit(partial(transfer.g2p, form, wall, GRID))
    beyond = gather(c["x"], c["v"], c["C"], *operands[1:]).health.beyond
    assert beyond > 100 if wall else beyond == 0
    pulls_equal(kernel, reference, operands, seed=2 if wall else 1)  # whose sums by the step do not cancel


def test_adjoints_repeat_bit_by_bit():
    c = cloud(3001, "float32")
    scattered, gathered = partial(cpu.p2g, "mls", GRID), lambda *o: cpu.g2p("mls", 1, GRID, *o).v

    def once():
        by_x, *_ = pull(scattered, p2g_operands(c))
        return [by_x, *pull(gathered, g2p_operands(c))]

    first = once()
    for _ in range(5):
        assert all(np.array_equal(a, b) for a, b in zip(first, once(), strict=True))


def test_particles_outside_and_not_finite_are_seen_and_write_nowhere_else():
    c = cloud(50, "float32")
    x = c["x"].at[3].set(jnp.array([0.01, 0.4, 0.5])).at[7, 1].set(2.99).at[9, 2].set(jnp.nan)
    nodes = jax.jit(partial(cpu.p2g, "mls", GRID))(*p2g_operands(c | {"x": x}))
    assert nodes[..., 3].sum() == pytest.approx(float(c["mass"].sum()), rel=0.2) or jnp.isnan(nodes).any()
    moved, reference = (
        jax.jit(partial(g2p, "mls", 1, GRID))(*g2p_operands(c | {"x": x})) for g2p in (cpu.g2p, transfer.g2p)
    )
    assert not moved.health.finite and not reference.health.finite
    assert moved.health.outside == reference.health.outside == 3
    assert jnp.isnan(moved.x[9]).any()


@pytest.mark.parametrize("count", [69, 3001])
def test_results_repeat_bit_by_bit_whichever_thread_took_what(count):
    c = cloud(count, "float32")

    @jax.jit
    def once():
        s, basis = svd_kernels.decompose(c["F"], SWEEPS[4])
        composed = svd_kernels.compose(basis, c["F"], s - 1, s)
        return cpu.p2g("mls", GRID, *p2g_operands(c)), cpu.g2p("mls", 1, GRID, *g2p_operands(c)), s, composed

    first = once()
    for _ in range(50):
        jax.tree.map(np.testing.assert_array_equal, once(), first)


def test_p2g_keeps_mass_and_momentum(x64):
    c = cloud(500, "float64")
    *_, dv, _ = operands = p2g_operands(c)
    nodes = cpu.p2g("gradient", GRID, *operands).sum((0, 1, 2))
    np.testing.assert_allclose(nodes[3], c["mass"].sum(), rtol=1e-13)
    np.testing.assert_allclose(nodes[:3], (c["mass"][:, None] * (c["v"] + dv)).sum(0), rtol=1e-10)


def test_kernels_under_vmap():
    clouds = [cloud(40, "float32", seed) for seed in range(3)]
    stacked = [jnp.stack(parts) for parts in zip(*(p2g_operands(c) for c in clouds))]
    got = jax.vmap(lambda *o: cpu.p2g("mls", GRID, *o))(*stacked)
    for nodes, c in zip(got, clouds):
        np.testing.assert_array_equal(nodes, cpu.p2g("mls", GRID, *p2g_operands(c)))


@pytest.mark.parametrize("form", ["mls", "gradient"])
def test_gradients_of_a_rollout_equal_the_reference(form, x64):
    def loss(speed, choice):
        model, state = block((3, 3, 3), dtype=np.float64, stress_form=form, kernels=choice)
        v = speed * jnp.sin(7 * state.x)
        end, _ = rollout(model, dataclasses.replace(state, v=v), frame_count=2, substeps=5)
        return (end.x**2).sum() + 1e-3 * (end.F[:, 0, 1] ** 2).sum()

    value, slope = map(float, jax.value_and_grad(loss)(0.3, "cpu"))
    expected, expected_slope = map(float, jax.value_and_grad(loss)(0.3, "reference"))
    assert value == pytest.approx(expected, rel=1e-12)
    assert slope == pytest.approx(expected_slope, rel=1e-10)
    h = 1e-5
    difference = float(loss(0.3 + h, "cpu") - loss(0.3 - h, "cpu")) / (2 * h)
    assert slope == pytest.approx(difference, rel=1e-6)


def laws(n, dtype):
    mu, lam = (jnp.full(n, value, dtype) for value in materials.lame_parameters(1e5, 0.3))

    def full(value):
        return jnp.full(n, value, dtype)

    return {
        "neo-hookean": materials.NeoHookean(mu, lam),
        "fixed-corotated": materials.FixedCorotated(mu, lam),
        "von-mises": materials.VonMises(mu, lam, full(2e3), full(1e3)),
        "plasticine": materials.Plasticine(mu, lam, full(2e3), full(1e4)),
        "sand": materials.DruckerPrager(mu, lam, full(0.6), full(0.0)),
        "foam": materials.Viscoplastic(mu, lam, full(2e3), full(10.0)),
        "snow": materials.Snow(mu, lam, full(0.025), full(0.0075), full(10.0), full(4.0)),
        "fluid": materials.Fluid(full(1e5)),
    }


@pytest.mark.parametrize("law", laws(1, np.float32))
def test_a_simulation_of_every_law_equals_the_reference(law, x64):
    def frames(choice):
        model, state = block(
            (4, 4, 4),
            low=(0.4, 0.4, 0.15),
            dtype=np.float64,
            gravity=jnp.array([0, 0, -9.8]),
            kernels=choice,
        )
        model = model.replace(materials=(laws(len(state.x), np.float64)[law],))
        state = dataclasses.replace(state, history=tuple(m.initial_history() for m in model.materials))
        v = state.v.at[:, 2].set(-2.0)
        return list(simulate(model, dataclasses.replace(state, v=v), frame_count=3, frame_dt=0.02))

    one, other = frames("cpu")[-1], frames("reference")[-1]
    assert one.substeps == other.substeps
    np.testing.assert_allclose(one.state.x, other.state.x, atol=1e-10)
    np.testing.assert_allclose(one.state.F, other.state.F, atol=1e-8)
    assert one.min_J == pytest.approx(other.min_J, abs=1e-8)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class TwiceAsStiff(materials.NeoHookean):
    """A law that the kernels know by its base only."""

    def stress(self, F, history=()):
        return 2 * super().stress(F, history)


def test_a_subclass_of_a_law_that_kernels_know_keeps_its_own_stress(x64):
    def end(choice):
        model, state = block((2, 2, 2), dtype=np.float64, kernels=choice)
        model = model.replace(materials=(TwiceAsStiff(model.materials[0].mu, model.materials[0].lam),))
        F = state.F.at[:, 0, 1].set(0.1)
        return rollout(model, dataclasses.replace(state, F=F), frame_count=1, substeps=5)[0]

    one, other = end("cpu"), end("reference")
    assert float(jnp.abs(other.v).max()) > 1e-3
    np.testing.assert_allclose(one.v, other.v, atol=1e-10)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("count", [0, 1, 8, 21])
def test_svd_and_isotropic_functions_equal_numpy_for_any_number_of_matrices(count, dtype, x64):
    F = (np.eye(3) + 0.5 * np.random.default_rng(count).normal(size=(count, 3, 3))).astype(dtype)
    with kernels.use_kernels("cpu"):
        U, s, V = svd(jnp.asarray(F))
        R = isotropic(lambda s, _: jnp.sign(s), jnp.asarray(F), None)  # the orthogonal factor
    eps = np.finfo(dtype).eps
    np.testing.assert_allclose(np.einsum("nij,nj,nkj->nik", U, s, V), F, atol=20 * eps)
    np.testing.assert_allclose(np.abs(s), np.linalg.svd(F.astype(float))[1], atol=20 * eps)
    u, _, vt = np.linalg.svd(F.astype(float))
    np.testing.assert_allclose(R, u @ vt, atol=200 * eps)


def test_without_numba_the_reference_serves_and_says_so_once(monkeypatch, caplog):
    choice.numba_missing.cache_clear()
    monkeypatch.setattr(choice, "importlib", Absent)
    try:
        with caplog.at_level(logging.WARNING):
            assert kernels.describe_kernels("auto") == "reference"
            assert not kernels.use_cpu("auto")
        assert [record.levelname for record in caplog.records] == ["WARNING"]
        with pytest.raises(UserError, match='"cpu"` cannot be used'):
            kernels.use_cpu("cpu")
    finally:
        choice.numba_missing.cache_clear()


class Absent:
    @staticmethod
    def import_module(name):
        raise ImportError("no module named 'numba'")


def test_the_choice_holds_for_what_is_traced_within():
    with kernels.use_kernels("reference"):
        assert not kernels.use_cpu()
    assert kernels.use_cpu()
    assert kernels.describe_kernels("auto").startswith("cpu (")


def test_where_the_arrays_lie_decides_on_a_machine_with_a_gpu(monkeypatch):
    """The default backend is a GPU: what lies on the CPU, by itself or by JAX's default device, takes the kernels."""
    cpu_device = jax.devices("cpu")[0]
    here = jax.device_put(np.ones(3), cpu_device)
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    assert not kernels.use_cpu()
    for device in (cpu_device, "cpu"):
        with jax.default_device(device):
            assert kernels.use_cpu()
    with kernels.use_device_of(here):
        assert kernels.use_cpu()
    with kernels.use_device_of(np.ones(3)):  # lies nowhere yet
        assert not kernels.use_cpu()


def test_rollouts_and_frames_take_the_kernels_for_arrays_on_the_cpu(monkeypatch):
    """Seen by what they ask for as they are traced."""
    asked = []
    use_cpu = choice.use_cpu
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    monkeypatch.setattr(kernels, "use_cpu", lambda *names: asked.append(use_cpu(*names)) or asked[-1])
    model, state = block((1, 1, 1), grid_cells=11)
    rollout(model, state, frame_count=1, substeps=1)
    assert asked and all(asked)
    asked.clear()
    *_, _ = simulate(model, state, frame_count=2, frame_dt=1e-4)
    assert asked and all(asked)
