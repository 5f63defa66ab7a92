"""The same problems on a peer."""

from __future__ import annotations

import numpy as np

from benchmarks.accuracy.study import Row, judge, row_of
from benchmarks.cases.base import Case, Numerics, Problem, Signal
from benchmarks.peers.base import Contact as PeerContact
from benchmarks.peers.base import Found, Material, PeerScene, Plane, drive, make_peer, run_in
from physagent_jax.mpm import DomainBox, FixedCorotated, HalfSpace, NeoHookean


def peer_scene(problem: Problem) -> PeerScene:
    """The problem in the peers' terms.

    Raises:
        NotImplementedError: It has something that peers have no counterpart for.
    """
    model, state = problem.model, problem.state
    if model.forces or model.constraints or len(model.materials) != 1 or model.viscosity is not None:
        raise NotImplementedError("forces, constraints, viscosity or several materials")
    solid = model.materials[0]
    if not isinstance(solid, NeoHookean | FixedCorotated):
        raise NotImplementedError(type(solid).__name__)
    mu, lam = np.asarray(solid.mu), np.asarray(solid.lam)
    planes, padding = [], None
    for boundary in model.boundaries:
        if isinstance(boundary, HalfSpace):
            planes.append(
                Plane(
                    tuple(np.asarray(boundary.point).tolist()),
                    tuple(np.asarray(boundary.normal).tolist()),
                    PeerContact(boundary.contact.value),
                    float(boundary.friction),
                )
            )
        elif isinstance(boundary, DomainBox):
            padding = boundary.padding
        else:
            raise NotImplementedError(type(boundary).__name__)
    grid = model.grid  # peers compute the whole cube of the domain, whatever our window leaves out
    return PeerScene.of(
        np.asarray(state.x, np.float32),
        v=np.asarray(state.v, np.float32),
        C=np.asarray(state.C, np.float32),
        volume=np.asarray(model.volume, np.float32),
        density=np.asarray(model.mass / model.volume, np.float32),
        youngs_modulus=mu * (3 * lam + 2 * mu) / (lam + mu),
        poissons_ratio=lam / (2 * (lam + mu)),
        material=Material.NEO_HOOKEAN if isinstance(solid, NeoHookean) else Material.JELLY,
        size=grid.dx * grid.cells,
        cells=grid.cells,
        gravity=(0.0, 0.0, 0.0) if model.gravity is None else tuple(np.asarray(model.gravity).tolist()),
        planes=tuple(planes),
        domain_box=padding,
        transfer=model.transfer,
        rpic_damping=model.rpic_damping,
    )


def theirs(case: Case, label: str, numerics: Numerics, name: str, found: Found) -> Row:
    """One run of a peer where it was ``found``, judged as ours is."""
    problem = case.problem(numerics)
    failed, errors, walls, setup = "", {}, (), float("nan")
    try:
        request = (peer_scene(problem), problem.dt, problem.steps, problem.every)
        done = run_in(found.python, name, *request) if found.python else drive(make_peer(name), *request)
    except (NotImplementedError, RuntimeError) as error:
        failed = f"{type(error).__name__}: {error}"
    else:
        walls, setup = (float(done.seconds.sum()),), done.setup_seconds
        nothing = np.zeros((len(done.x[0]), 3, 3))
        values = np.stack(
            [np.atleast_1d(problem.observe(x, v, nothing, nothing)) for x, v in zip(done.x[1:], done.v[1:])]
        )
        last = (done.x[-1], done.v[-1], nothing, nothing)
        signal = Signal(done.steps[1:] * problem.dt, np.asarray(values, float), walls, setup, last)
        if np.isfinite(signal.values).all():
            errors, failed = judge(case, problem, signal)
        else:
            failed = "not finite"
    return row_of(case, name, label, problem, numerics, walls, setup, errors, failed)
