"""Play between the teeth of a gear."""

from collections.abc import Sequence

from modal_core.compiled import compiled
from model_gap.laws.law import Array, Follow, JointLaw, Lane

# Of the play: teeth under less static twist than this rest between the flanks, not on one.
CENTRED = 1e-3


@compiled
def play(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque, continuous in the twist; between steps it runs straight."""
    load, slope, give = constants[0], constants[1], constants[2]
    lower, upper = constants[3], constants[4]
    between = -load - slope * (twist + give * load)
    return min(max(between, lower), upper), 0.0


class BacklashLaw(JointLaw):
    """k·dz(e + e_r, b) less the linear spring; values b [rad] and the share of gravity preload.

    Solved between the flanks; on them the torque is constant.
    """

    preloaded = True
    sees = Follow.PARTED
    sees_first = Follow.PARTED
    of_spring = True
    solve = play

    @staticmethod
    def constants(values: Sequence[float], lane: Lane) -> Sequence[float]:
        """Return the load, how the torque falls between the flanks, and what it is on them."""
        gap, share = values
        k, rest = lane.stiffness, share * lane.static_twist
        place = rest + gap * min(max(rest / (CENTRED * gap), -1.0), 1.0)
        slope = k / max(1.0 - lane.give * k, 0.05)
        return k * rest, slope, lane.give, k * (place - gap - rest), k * (place + gap - rest)
