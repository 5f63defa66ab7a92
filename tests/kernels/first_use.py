"""A small gradient for processes that use the kernels for the first time; importing this computes nothing."""

import dataclasses
import multiprocessing
import threading

import jax
import numpy as np

from physagent_jax.mpm import Grid, Model, NeoHookean, State, rollout

LIMIT = 200  # [s]


def compute_gradient(count=40):
    """Derivative of a rollout of ``count`` stretched particles by their stiffness."""
    x = np.random.default_rng(0).uniform(0.4, 0.6, (count, 3)).astype(np.float32)
    one = np.ones(count, np.float32)
    state = State.at_rest(x)
    state = dataclasses.replace(state, F=1.1 * state.F)

    def loss(modulus):
        law = NeoHookean(modulus * one, 6e3 * one)
        model = Model(Grid.whole(1.0, 16), np.float32(1e-3), None, one, 1e-3 * one, (law,))
        end, _ = rollout(model, state, frame_count=2, substeps=3)
        return (end.x**2).sum()

    return float(jax.grad(loss)(4e3))


def compute_in_threads(thread_count, shape_count):
    """Results of threads that begin together, of ``shape_count`` different programs; whatever one raises is raised."""
    together, results, errors = threading.Barrier(thread_count), {}, []

    def work(number):
        try:
            together.wait()
            results[number] = compute_gradient(40 + number % shape_count)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=work, args=(number,), daemon=True) for number in range(thread_count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(LIMIT)
    if errors:
        raise errors[0]
    assert len(results) == thread_count, "threads wait for each other"
    return [results[number] for number in range(thread_count)]


def compute_in_processes(method, count):
    """Results of ``count`` processes that begin together, begun as ``method`` says."""
    context = multiprocessing.get_context(method)
    with context.Pool(count) as pool:
        return pool.map_async(compute_gradient, [40] * count, chunksize=1).get(LIMIT)
