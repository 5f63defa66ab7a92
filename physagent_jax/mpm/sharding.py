"""One simulation on several devices: each holds a share of the particles, all hold the same grid.

Every device scatters its own particles; momentum and mass are summed at the nodes over the devices (beside a few
numbers, the one exchange of a substep), then each updates the whole grid and gathers for its own particles. It is the
`step` of a single device, with `Model.axis` set.

All devices run one program on arrays of one shape, so every material's block of particles is split evenly. Where it
does not divide, massless twins of its last particle fill up: whatever happens to that particle happens to them, and
they do nothing to anyone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from physagent_jax.core.errors import UserError
from physagent_jax.mpm.conform import conform
from physagent_jax.mpm.fields import COUNT, HELD, PER_HELD, find_fields, find_owner
from physagent_jax.mpm.rollout import rollout
from physagent_jax.mpm.state import Model, State

AXIS = "particles"
"""The mesh axis along which `rollout_sharded` splits the particles."""


def rollout_sharded(
    model: Model,
    state: State,
    devices: Sequence[Any] | None = None,
    *,
    frame_count: int,
    substeps: int,
) -> tuple[State, State]:
    """`rollout` with the particles split over ``devices``; the same results to round-off, differentiable in reverse.

    Every device exchanges and updates all nodes in every substep: only where its particles outweigh them can this pay.
    The transfers are the pure JAX ones: the kernels of `mpm.kernels` use all cores of the machine for one device, and
    have not been shown to be safe where several devices call them at once.

    Args:
        model: As in `rollout`, with ``kernels`` "auto" or "reference". Body forces of one's own must sum over particles
            with `mpm.reductions.sum_particles`. Which particles the constraints hold must be known, not traced.
        state: The initial state.
        devices: Devices to split over; None = all of the default backend.
        frame_count: As in `rollout`.
        substeps: Per frame.

    Returns:
        The final state, and those at the end of every frame, particles in the order of ``state``.

    Raises:
        UserError: ``model`` cannot be split, or is at odds with ``state``.
    """
    if model.kernels == "cpu":
        raise UserError(
            "the CPU kernels serve one device only", got='kernels="cpu"', do='Use "auto" or "reference"'
        )
    model, state = conform(model, state)
    mesh = Mesh(np.asarray(jax.devices() if devices is None else devices), (AXIS,))
    layout = ParticleLayout(tuple(material.count for material in model.materials), mesh.size)
    split = layout.split(model, state)
    sharded = jax.device_put(split, _map_specs(lambda spec: NamedSharding(mesh, spec), find_specs(split)))
    return _run(*sharded, layout, mesh, frame_count, substeps)


@partial(jax.jit, static_argnums=(2, 3, 4, 5))
def _run(
    model: Model, state: State, layout: ParticleLayout, mesh: Mesh, frame_count: int, substeps: int
) -> tuple[State, State]:
    inward = find_specs((model, state))
    outward = inward[1], _map_specs(lambda spec: PartitionSpec(None, *spec), inward[1])
    run = partial(rollout, frame_count=frame_count, substeps=substeps)
    # Unchecked: JAX 0.10 otherwise refuses derivatives that evaluate linear maps at constants, as in `linalg.spectral`.
    split = jax.shard_map(run, mesh=mesh, in_specs=inward, out_specs=outward, check_vma=False)
    end, path = split(model, state)
    return layout.unpermute(end, 0), layout.unpermute(path, 1)


def find_specs(split: tuple[Model, State]) -> tuple[Any, Any]:
    """The partition of each array of a model and a state over the mesh."""

    def spec(path, leaf):
        return PartitionSpec(AXIS) if jnp.ndim(leaf) and find_owner(split, path) else PartitionSpec()

    return jax.tree.map_with_path(spec, split)


def _map_specs(function, specs):
    return jax.tree.map(function, specs, is_leaf=lambda part: isinstance(part, PartitionSpec))


@dataclasses.dataclass(frozen=True)
class ParticleLayout:
    """The place of each particle after the split.

    Attributes:
        counts: Particles per material.
        devices: How many.
    """

    counts: tuple[int, ...]
    devices: int

    @cached_property
    def order(self) -> np.ndarray:
        """Particle in each place, device after device, shape (places,)."""
        starts = np.cumsum((0, *self.counts))
        return self._join([start + self._fill_block(count) for start, count in zip(starts, self.counts)])

    @cached_property
    def real(self) -> np.ndarray:
        """Return whether it is that particle itself and not a twin, shape (places,)."""
        return self._join([np.arange(len(self._fill_block(count))) < count for count in self.counts])

    def split(self, model: Model, state: State) -> tuple[Model, State]:
        """Both with their particles in their places, `Model.axis` set.

        Raises:
            UserError: The model cannot be split.
        """
        constraints = tuple(self._split_constraint(constraint) for constraint in model.constraints)
        model, state = self._split(model.replace(constraints=()), state)
        return model.replace(constraints=constraints), state

    def unpermute(self, state: State, axis: int) -> State:
        """The particles of a split state in their old order, which runs along ``axis`` of its arrays."""
        place = np.empty(self.real.sum(), int)
        place[self.order[self.real]] = np.flatnonzero(self.real)
        arrays = {name: jnp.take(getattr(state, name), place, axis) for name in ("x", "v", "C", "F")}
        history = tuple(
            past if isinstance(past, tuple) else jax.lax.slice_in_dim(past, 0, count, axis=axis)
            for past, count in zip(state.history, self.counts)
        )
        return dataclasses.replace(state, history=history, **arrays)

    def _fill_block(self, count: int) -> np.ndarray:
        """Particle of a material in each of the places of its block, shape (devices * share,)."""
        share = -(-count // self.devices)
        return np.minimum(np.arange(self.devices * share), count - 1)

    def _join(self, blocks: Sequence[np.ndarray]) -> np.ndarray:
        return np.concatenate([block.reshape(self.devices, -1) for block in blocks], axis=1).ravel()

    @partial(jax.jit, static_argnums=0)  # one program instead of a few for every array
    def _split(self, model: Model, state: State) -> tuple[Model, State]:
        mass, volume = (jnp.where(self.real, own[self.order], 0) for own in (model.mass, model.volume))
        model = model.replace(
            mass=mass,
            volume=volume,
            viscosity=None if model.viscosity is None else model.viscosity[self.order],
            materials=tuple(self._split_material(*both) for both in zip(model.materials, self.counts)),
            forces=self._split_forces(model.forces),
            kernels="reference",
            axis=AXIS,
        )
        arrays = {name: getattr(state, name)[self.order] for name in ("x", "v", "C", "F")}
        history = tuple(
            past if isinstance(past, tuple) else past[self._fill_block(count)]
            for past, count in zip(state.history, self.counts)
        )
        return model, dataclasses.replace(state, history=history, **arrays)

    def _split_material(self, material: Any, count: int) -> Any:
        places = self._fill_block(count)
        share = len(places) // self.devices
        counted = find_fields(material, **COUNT)
        if counted:
            return dataclasses.replace(material, **dict.fromkeys(counted, share))
        leaves, structure = jax.tree.flatten(material)
        each = [jnp.ndim(leaf) > 0 for leaf in leaves]
        fits = all(len(leaf) == count for leaf, own in zip(leaves, each) if own)
        split = [leaf[places] if own else leaf for leaf, own in zip(leaves, each)]
        part = jax.tree.unflatten(
            structure, [leaf[:share] if own else leaf for leaf, own in zip(split, each)]
        )
        if not fits or part.count != share:
            raise UserError(
                f"{type(material).__name__} cannot be split: its arrays must have one entry per particle, and its "
                "count must follow from them"
            )
        return jax.tree.unflatten(structure, split)

    def _split_forces(self, forces: tuple[Any, ...]) -> tuple[Any, ...]:
        def split(path, leaf):
            if find_owner(forces, path) == "particle":
                return leaf[self.order]
            if jnp.ndim(leaf) and len(leaf) == sum(self.counts):
                raise UserError(
                    f"a body force has a field `{getattr(path[-1], 'name', '')}` as long as there are particles: is "
                    "it one per particle?",
                    do="Mark it with `mpm.fields.PER_PARTICLE` if so; else let the two differ in length",
                )
            return leaf

        return jax.tree.map_with_path(split, forces)

    def _split_constraint(self, constraint: Any) -> Any:
        """``constraint`` with the held places of each device, in terms of that device's particles.

        Devices with fewer than others fill up with a place beyond the last: what is written there is dropped.
        """
        indices = find_fields(constraint, **HELD)
        if len(indices) != 1:
            raise UserError(
                f"the constraint {type(constraint).__name__} cannot be split over devices",
                do="Mark the field with the particles that it holds with `mpm.fields.HELD`",
            )
        particles = _concretize(getattr(constraint, indices[0]))
        claim = np.full(sum(self.counts), -1)
        real = np.flatnonzero(particles < len(claim))  # the others stand for no particle
        claim[particles[real]] = real
        claims = claim[self.order].reshape(self.devices, -1)
        places_per_device = [np.flatnonzero(row >= 0) for row in claims]
        local = np.full((self.devices, max(map(len, places_per_device))), claims.shape[1], np.int32)
        which = np.full(local.shape, -1)
        for device, places in enumerate(places_per_device):
            local[device, : len(places)], which[device, : len(places)] = places, claims[device, places]
        places, which = jnp.asarray(local.ravel()), which.ravel()
        split = {
            name: jnp.broadcast_to(getattr(constraint, name), particles.shape)[which]
            for name in find_fields(constraint, **PER_HELD)
            if getattr(constraint, name) is not None
        }
        return dataclasses.replace(constraint, **split | {indices[0]: places})


def _concretize(particles: jax.Array) -> np.ndarray:
    """The indices as numbers.

    Raises:
        UserError: They are being traced.
    """
    try:
        return np.asarray(particles)
    except jax.errors.TracerArrayConversionError:
        raise UserError(
            "the particles of a constraint must be known before anything is traced",
            do="Let the model with its constraints be a constant of what you differentiate or compile",
        ) from None
