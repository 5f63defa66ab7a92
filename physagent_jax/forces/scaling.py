"""Closed forms of what M = 1 means: from an object and a clip to the k of skills.

| quantity    | k             | unopposed, with                                                     |
|-------------|---------------|---------------------------------------------------------------------|
| translation | 2 s L / T^2   | s = `TRAVEL` by the clip's end                                      |
| scale       | 4 E e/(rho L) | e = `STRAIN`, linear mean strain                                    |
| impulse     | s L / T       | s = `TRAVEL` by the clip's end                                      |
| torque      | 2 theta / T^2 | theta = `TURN` by the clip's end                                    |
| velocity    | s L / T       | s = `PRESCRIBED_TRAVEL`; a part or plate goes by the extent along v |
| rotation    | theta / T     | theta = `TURN`                                                      |

L is the object's longest extent, E and rho its mean stiffness and density, T the clip's duration.
"""

from __future__ import annotations

import math

from pydantic import ValidationError

from physagent_jax.core.reading import format_validation_error
from physagent_jax.forces.calibration import EXPECTED_SWAY, PRESCRIBED_TRAVEL, STRAIN, SWING, TRAVEL, TURN
from physagent_jax.forces.opposition import describe_opposition
from physagent_jax.forces.schema import Holding, Opposition, SkillScaling
from physagent_jax.forces.swinging import describe_swing


def make_closed_form_scaling(
    *,
    extent: float,
    youngs_modulus: float,
    density: float,
    duration: float,
    damping_rate: float = 0.0,
    opposition: Opposition | None = None,
    holding: Holding | None = None,
) -> SkillScaling:
    """The k of every skill for a free object; with damping, those that move it as far.

    Args:
        extent: Longest extent L [m].
        youngs_modulus: Mean E [Pa].
        density: Mean rho [kg/m^3].
        duration: T [s].
        damping_rate: Rate d at which velocities decay [1/s]: a push k then moves by k (d T - 1 + e^(-d T)) / d^2
            instead of k T^2 / 2, a blow k by k (1 - e^(-d T)) / d instead of k T.
        opposition: What else works against the motion.
        holding: How far the object gives way where it is held.

    Raises:
        UserError: These values give accelerations beyond what float32 can compute with.
    """
    reason = (
        f"closed form for L = {extent:.3g} m, E = {youngs_modulus:.3g} Pa, "
        f"rho = {density:.3g} kg/m^3, T = {duration:.3g} s"
    )
    blow_path, push_path = duration, 0.5 * duration**2  # way of a blow and of a push with k = 1
    if (decay := damping_rate * duration) > 1e-6:
        blow_path = -math.expm1(-decay) / damping_rate
        push_path = (decay + math.expm1(-decay)) / damping_rate**2
        reason += f", damping {damping_rate:.3g} /s"
    if opposition is not None:
        reason += f"; {describe_opposition(opposition)}"
    swing = (SWING if holding is None else EXPECTED_SWAY) * extent
    reason += f"; {describe_swing(swing)}"
    if holding is not None:
        reason += (
            f"; held: a push or blow of 1 is to move its centre by {holding.shift:.3g} m, with {holding.least:.3g} to "
            f"{holding.most:.3g} m/s^2"
        )
    try:
        return SkillScaling(
            translation=TRAVEL * extent / push_path,
            scale=4 * youngs_modulus * STRAIN / (density * extent),
            impulse=TRAVEL * extent / blow_path,
            torque=TURN / push_path,
            velocity=PRESCRIBED_TRAVEL * extent / duration,
            rotation=TURN / duration,
            swing=swing,
            damping_rate=damping_rate,
            opposition=opposition,
            holding=holding,
            reason=reason,
        )
    except ValidationError as error:
        do = "Use a longer clip or a softer, denser material"
        raise format_validation_error(error, f"forces in {reason}", do=do) from None
