"""Differentiable Material Point Method: `step(model, state) -> state`, driven by `simulate` and `rollout`."""

from physagent_jax.mpm.boundaries import Contact as Contact
from physagent_jax.mpm.boundaries import Cuboid as Cuboid
from physagent_jax.mpm.boundaries import DomainBox as DomainBox
from physagent_jax.mpm.boundaries import HalfSpace as HalfSpace
from physagent_jax.mpm.constraints import PrescribedMotion as PrescribedMotion
from physagent_jax.mpm.materials import FixedCorotated as FixedCorotated
from physagent_jax.mpm.materials import NeoHookean as NeoHookean
from physagent_jax.mpm.materials import lame_parameters as lame_parameters
from physagent_jax.mpm.rollout import Frame as Frame
from physagent_jax.mpm.rollout import rollout as rollout
from physagent_jax.mpm.rollout import simulate as simulate
from physagent_jax.mpm.state import Grid as Grid
from physagent_jax.mpm.state import Model as Model
from physagent_jax.mpm.state import State as State
from physagent_jax.mpm.step import step as step
from physagent_jax.mpm.timestep import stable_dt as stable_dt
from physagent_jax.mpm.window import fit_window as fit_window
from physagent_jax.mpm.window import smallest_window as smallest_window
