"""A scene's numbers as a pytree: those that it has and no others; put back, they are a scene that says them."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import Action, ActionType, ForceField, Holding, Opposition
from physagent_jax.mpm.step import kirchhoff_stress
from physagent_jax.scene import config as c
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.parameters import MaterialParameters, SceneParameters
from tests.scene.small_scenes import (
    IMPOSED,
    JELLY,
    SAND,
    TERMS,
    make_config,
    make_rich_scene,
    make_small_body,
)

pytestmark = pytest.mark.filterwarnings("ignore:the object is thinly filled")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("jelly")


@pytest.fixture(scope="module")
def body(folder):
    return make_small_body(folder)


@pytest.fixture(scope="module")
def rich(folder, body):
    return make_rich_scene(folder, body)


def differ(one, other):
    """The largest relative difference of two equal pytrees' leaves."""
    assert jax.tree.structure(one) == jax.tree.structure(other)
    largest = 0.0
    for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other)):
        if hasattr(a, "dtype"):  # not what an envelope has as a default
            assert a.dtype == b.dtype
        a, b = np.asarray(a), np.asarray(b)
        assert a.shape == b.shape
        if a.size:
            scale = max(np.abs(a[np.isfinite(a)].astype(float)).max(initial=0), 1e-30)
            largest = max(largest, np.abs(np.where(a == b, 0.0, a.astype(float) - b)).max() / scale)
    return largest


def parts(scene):
    return scene.model, scene.state


def test_untouched_numbers_are_the_scene_bit_by_bit(rich):
    numbers = SceneParameters.of(rich)
    assert differ(parts(rich.with_parameters(numbers)), parts(rich)) == 0
    assert all(leaf.dtype == np.float64 for leaf in jax.tree.leaves(numbers))
    traced = jax.jit(lambda numbers: parts(rich.with_parameters(numbers)))(numbers)
    assert differ(parts(rich), traced) < 1e-6


def test_the_numbers_are_those_that_the_scene_has(rich, folder, body):
    numbers = SceneParameters.of(rich)
    jelly, sand, metal = numbers.materials
    assert set(jelly.get_given()) == {"density", "youngs_modulus", "poissons_ratio", "viscosity"}
    assert set(sand.get_given()) == {
        "density",
        "youngs_modulus",
        "poissons_ratio",
        "friction_angle",
        "cohesion",
    }
    assert set(metal.get_given()) >= {"yield_stress", "hardening_modulus"}
    wind, attractor, _, turbulence, push = numbers.forces
    assert (wind.speed, wind.envelope.frequency, wind.envelope.rise) == (8.0, 4.0, None)
    assert (attractor.envelope.start, attractor.envelope.end, attractor.weight) == (0.0, None, None)
    assert turbulence.wave_vectors is None and turbulence.strength == 3.0
    assert push.envelope.rise == pytest.approx(0.02)
    blow, motion = numbers.constraints
    assert motion.particles is None and motion.velocity.shape == (3,) and blow.weight is None
    assert [value is not None for value in numbers.friction] == [False, True, False]

    plain = SceneParameters.of(compile_scene(make_config(folder), body, folder))
    fluid = c.Material(model=c.MaterialModel.FLUID, bulk_modulus=2e4)
    assert plain.force_field is plain.gravity is plain.damping_rate is None
    assert plain.forces == plain.constraints == ()
    assert set(MaterialParameters.of(fluid).get_given()) == {"density", "bulk_modulus"}
    rigid = c.Material(model=c.MaterialModel.RIGID)
    assert set(MaterialParameters.of(rigid).get_given()) == {"density"}
    assert set(MaterialParameters.of(rigid.changed(restitution=0.5)).get_given()) == {
        "density",
        "restitution",
    }


def test_every_number_of_every_material_has_a_place():
    names = {field.name for field in dataclasses.fields(MaterialParameters)}
    known = {name for each in c.MODEL_PARAMETERS.values() for name in each}
    choices = {"damping_ratio", "tension", "fragments"}  # they choose a law or its places
    assert names == {"density", "youngs_modulus", "poissons_ratio"} | known - choices


@pytest.mark.parametrize("traced", [False, True])
def test_given_numbers_are_those_of_a_scene_that_says_them(rich, traced, folder, body):
    """Materials by the law's own conversion, masses, forces per particle, fields, walls; traced to round-off."""
    scaling = make_closed_form_scaling(extent=0.8, youngs_modulus=3e4, density=400.0, duration=0.1)
    one, other = JELLY.changed(youngs_modulus=5e4, poissons_ratio=0.1, density=300.0, viscosity=3.0), SAND
    other = other.changed(friction_angle=20.0, cohesion=10.0, density=1000.0)
    wind, attractor, vortex, turbulence, push = TERMS
    changed = dict(
        material=one,
        material_regions=(
            rich.config.material_regions[0].model_copy(update={"material": other}),
            rich.config.material_regions[1],
        ),
        forces=(
            wind.model_copy(update={"speed": 3.0, "direction": (0.0, 0.6, 0.8)}),
            attractor.model_copy(update={"power": 2.0}),
            vortex.model_copy(update={"core": 0.5, "point": (1.4, 1.5, 1.5)}),
            turbulence.model_copy(update={"length_scale": 0.7}),
            push.model_copy(update={"acceleration": (0.0, 0.0, 3.0)}),
        ),
        constraints=(
            IMPOSED[0].model_copy(update={"force": (0.0, 2.0, 1.0)}),
            IMPOSED[1].model_copy(update={"velocity": (0.0, 0.0, 1.0)}),
        ),
        boundaries=tuple(
            each.model_copy(update={"friction": 0.7}) if isinstance(each, c.HalfSpace) else each
            for each in rich.config.boundaries
        ),
        gravity=(0.0, 1.0, -2.0),
        transfer=c.Transfer(damping_rate=0.9),
        scaling=scaling,
    )
    wanted = make_rich_scene(folder, body, **changed)
    base = make_rich_scene(folder, body, scaling=scaling)
    numbers = SceneParameters.of(wanted)

    def put(numbers):
        made = base.with_parameters(numbers)
        return made.model.replace(dt=wanted.model.dt), made.state

    got = jax.jit(put)(numbers) if traced else put(numbers)
    assert differ(parts(wanted), got) < (1e-6 if traced else 2e-7)


def test_what_is_left_out_is_kept(rich):
    numbers = SceneParameters.of(rich)
    stiffer = MaterialParameters(youngs_modulus=np.asarray(6e4))
    materials = (stiffer, None, None)
    scene = rich.with_parameters(SceneParameters(materials=materials))
    scene = scene.with_parameters(
        SceneParameters(materials=(MaterialParameters(poissons_ratio=np.asarray(0.1)), None, None))
    )
    both = dataclasses.replace(stiffer, poissons_ratio=np.asarray(0.1))
    at_once = rich.with_parameters(SceneParameters(materials=(both, None, None)))
    assert differ(parts(scene), parts(at_once)) == 0 and scene.changed and not rich.changed
    np.testing.assert_array_equal(scene.model.mass, rich.model.mass)
    alone = rich.with_parameters(numbers.force_field)
    whole = rich.with_parameters(dataclasses.replace(SceneParameters(), force_field=numbers.force_field))
    assert isinstance(numbers.force_field, ForceFieldParameters) and differ(parts(alone), parts(whole)) == 0


def test_numbers_may_be_given_per_particle(rich):
    """Those of the particles of a material count, whichever block they lie in; derivatives are per particle too."""
    count = len(rich.state.x)
    stiffness = np.linspace(1e4, 9e4, count)
    velocity = np.random.default_rng(0).normal(size=(count, 3))

    def put(stiffness):
        materials = (None, MaterialParameters(youngs_modulus=stiffness), None)
        return rich.with_parameters(SceneParameters(materials=materials, velocity=velocity))

    made = put(stiffness)
    assert {type(law).__name__ for law in made.model.materials} == {"NeoHookean", "DruckerPrager", "VonMises"}
    start = 0
    for law in made.model.materials:
        mine = rich.choice[start : start + law.count]
        wanted = stiffness[start : start + law.count] / 2.6
        own = np.array([3e4, 0, 4e4])[mine] / 2.6
        np.testing.assert_allclose(law.mu, np.where(mine == 1, wanted, own), rtol=1e-6)
        start += law.count
    np.testing.assert_allclose(made.state.v, velocity, rtol=1e-6)
    slope = jax.jit(jax.grad(lambda e: sum(law.mu.sum() for law in put(e).model.materials)))(stiffness)
    np.testing.assert_allclose(slope, np.where(rich.choice == 1, 1 / 2.6, 0), rtol=1e-5)


@pytest.mark.parametrize("traced", [False, True])
def test_a_rigid_body_gets_another_restitution(traced, folder, body):
    rigid = c.Material(model=c.MaterialModel.RIGID, restitution=0.5)
    scenes = [
        compile_scene(make_config(folder, material=rigid.changed(restitution=e)), body, folder)
        for e in (0.5, 0.8)
    ]
    numbers = SceneParameters(materials=(MaterialParameters(restitution=np.asarray(0.8)),))

    def put(numbers):
        return parts(scenes[0].with_parameters(numbers))

    assert differ(parts(scenes[1]), jax.jit(put)(numbers) if traced else put(numbers)) < 1e-7
    with pytest.raises(UserError, match="one coefficient of restitution"):
        put(SceneParameters(materials=(MaterialParameters(restitution=np.ones(len(scenes[0].state.x))),)))


def test_a_longer_direction_is_the_same_direction(rich):
    numbers = SceneParameters.of(rich)
    wind = dataclasses.replace(numbers.forces[0], direction=3 * numbers.forces[0].direction)
    longer = dataclasses.replace(numbers, forces=(wind, *numbers.forces[1:]))
    assert differ(parts(rich.with_parameters(longer)), parts(rich)) < 1e-7


def test_what_bears_its_weight_goes_on_bearing_it(folder, body):
    """Softer, heavier matter in equilibrium gets the stretch with which its law has the stress that it needs."""
    config = make_config(
        folder,
        material=JELLY.changed(youngs_modulus=3e5),
        start="equilibrium",
        always_gravity=True,
        boundaries=(c.DomainBox(), c.HalfSpace(point=(1.5, 1.5, 1.2), normal=(0, 0, 1), friction=0.5)),
    )
    scene = compile_scene(config, body, folder)
    assert float(jnp.abs(scene.state.F - jnp.eye(3)).max()) > 0.005
    before = kirchhoff_stress(scene.model, scene.state)

    def put(e, density, pull):
        material = MaterialParameters(youngs_modulus=e, density=density)
        numbers = SceneParameters(materials=(material,), gravity=pull * np.asarray(config.gravity))
        made = scene.with_parameters(numbers)
        return made.model, made.state

    for made in (put, jax.jit(put)):
        model, state = made(1.5e5, 500.0, 0.8)
        after = kirchhoff_stress(model, state)
        np.testing.assert_allclose(after, before, atol=2e-4 * float(jnp.abs(before).max()))
        assert float(jnp.abs(state.F - scene.state.F).max()) > 0.005
    assert differ(parts(scene.with_parameters(SceneParameters.of(scene))), parts(scene)) == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"materials": (MaterialParameters(),)}, "one entry for each that the scene has, 3"),
        ({"friction": (None,) * 4}, "one entry for each that the scene has, 3"),
        ({"friction": (0.1, None, None)}, "a number that the scene does not have"),
        ({"materials": (MaterialParameters(bulk_modulus=1.0), None, None)}, "does not have"),
        ({"materials": (MaterialParameters(density=np.ones(3)), None, None)}, "one number per particle"),
        ({"velocity": np.ones(2)}, "must have the shape"),
        ({"force_field": ForceFieldParameters()}, "one entry per entry of the force field, 1"),
        ({"gravity": np.ones(2)}, "must have the shape"),
    ],
)
def test_numbers_that_are_not_the_scene_s_are_refused(change, message, rich):
    with pytest.raises(UserError, match=message):
        rich.with_parameters(dataclasses.replace(SceneParameters(), **change))


def test_terms_of_another_kind_are_refused(rich):
    numbers = SceneParameters.of(rich)
    with pytest.raises(UserError, match="the numbers of a Wind"):
        rich.with_parameters(dataclasses.replace(numbers, forces=(numbers.forces[4], *numbers.forces[1:])))
    wind = dataclasses.replace(numbers.forces[0], speed=np.ones(2))
    with pytest.raises(UserError, match="must have the shape"):
        rich.with_parameters(dataclasses.replace(numbers, forces=(wind, *numbers.forces[1:])))


@pytest.mark.parametrize(
    "opposing",
    [
        dict(
            opposition=Opposition(
                friction=3.0, weight=9.8, turning=2.0, tipping=5.0, lever=0.2, travel=0.8, time=1.4
            )
        ),
        dict(
            holding=Holding(
                compliance=((2e-3, 0, 0), (0, 2e-3, 0), (0, 0, 1e-3)), shift=0.1, least=1.0, most=300.0
            )
        ),
    ],
)
@pytest.mark.parametrize("traced", [False, True])
def test_a_longer_vector_is_a_larger_magnitude_where_something_opposes(opposing, traced, folder, body):
    """The compensation goes by the direction alone, whatever the vector's length."""
    windows = ((0, 1), (1, 2), (0, 2))
    kinds = (ActionType.TRANSLATION, ActionType.IMPULSE, ActionType.TORQUE)
    field = ForceField(
        actions=tuple(
            Action(action_type=kind, vector=(0.6, 0.0, 0.8), magnitude=0.8, active_time=window)
            for kind, window in zip(kinds, windows)
        )
    )
    scaling = make_closed_form_scaling(extent=0.8, youngs_modulus=3e4, density=400.0, duration=0.1)
    config = make_config(folder, force_field=field, scaling=scaling.model_copy(update=opposing))
    scene = compile_scene(config, body, folder)
    own = ForceFieldParameters.of(field, scene.config.timing.frame_count)

    def compile_with(values):
        return scene.with_parameters(values).model.forces

    def change(name, factor):
        actions = tuple(
            dataclasses.replace(each, **{name: factor * getattr(each, name)}) for each in own.actions
        )
        return dataclasses.replace(own, actions=actions)

    compile_ = jax.jit(compile_with) if traced else compile_with
    one, other = compile_(change("vector", 1.5)), compile_(change("magnitude", 1.5))
    assert differ(one, other) < 1e-6
    assert differ(one, compile_(own)) > 0.01
