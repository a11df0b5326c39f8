"""A spring whose stiffness depends on how fast its joint turns."""

from collections.abc import Sequence

from modal_core.compiled import compiled
from model_gap.laws.law import Array, Follow, JointLaw, Lane
from model_gap.laws.parabola import bent


@compiled
def speed_spring(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque: linear in the twist."""
    change, rest, give = constants[0], constants[1], constants[2]
    added = change * abs(motor_speed)
    torque = added * (rest + twist) / max(1.0 + give * added, 0.2)
    return torque, bent(memory, torque, abs(give * added))


class SpeedStiffnessLaw(JointLaw):
    """k β |q'| (r + e), r the twist at rest; values β [s/rad] and the share of gravity in r."""

    preloaded = True
    sees_first = Follow.MEASURED
    of_spring = True
    solve = speed_spring

    @staticmethod
    def constants(values: Sequence[float], lane: Lane) -> Sequence[float]:
        """Return the change of stiffness per speed, the twist at rest and the give."""
        beta, share = values
        return lane.stiffness * beta, share * lane.static_twist, lane.give
