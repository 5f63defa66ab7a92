"""Body-force terms. Pytrees; every magnitude is a differentiable leaf.

All are accelerations, evaluated at the particles and accumulated on the grid by P2G, so that a region is
exact and the total force is that of the particles. Each implements `mpm.protocols.BodyForce`. The skills
compile to `Stretch`, `Torque`, `UniformAcceleration` and `VelocityChange`, over the ground with `PushCompensation`,
`TurnCompensation`, `Balance`, `AxleBalance`, `Landing`, `Settling`, `Launch` and `Quiver`; the others follow a
time profile (`forces.envelope`) and are for scenes and library users.
"""

from physagent_jax.forces.terms.attractor import Attractor as Attractor
from physagent_jax.forces.terms.balance import AxleBalance as AxleBalance
from physagent_jax.forces.terms.balance import Balance as Balance
from physagent_jax.forces.terms.balance import Landing as Landing
from physagent_jax.forces.terms.balance import Settling as Settling
from physagent_jax.forces.terms.friction import PushCompensation as PushCompensation
from physagent_jax.forces.terms.friction import TurnCompensation as TurnCompensation
from physagent_jax.forces.terms.quiver import Quiver as Quiver
from physagent_jax.forces.terms.rigid import mass_centre as mass_centre
from physagent_jax.forces.terms.rigid import remove_rigid_part as remove_rigid_part
from physagent_jax.forces.terms.stretch import Stretch as Stretch
from physagent_jax.forces.terms.torque import Torque as Torque
from physagent_jax.forces.terms.turbulence import Turbulence as Turbulence
from physagent_jax.forces.terms.uniform import UniformAcceleration as UniformAcceleration
from physagent_jax.forces.terms.uniform import UniformField as UniformField
from physagent_jax.forces.terms.velocity_change import Launch as Launch
from physagent_jax.forces.terms.velocity_change import Touchdown as Touchdown
from physagent_jax.forces.terms.velocity_change import VelocityChange as VelocityChange
from physagent_jax.forces.terms.vortex import Vortex as Vortex
from physagent_jax.forces.terms.wind import Wind as Wind
from physagent_jax.forces.terms.wind import make_still_air as make_still_air
