"""What a torque law is: solved implicitly, step by step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# (constants, memory, twist, rate, motor speed) to (torque, surplus)
Solve = Callable[[Array, Array, float, float, float], tuple[float, float]]
MEMORY = 6


class Follow(Enum):
    """Which twist a law is evaluated on."""

    PREDICTED = 'predicted'
    PARTED = 'measured above a few hertz, predicted below'
    MEASURED = 'measured'


@dataclass(frozen=True)
class Lane:
    """What a torque finds in one joint of one record.

    Parameters
    ----------
    stiffness : float [N m/rad]
        Of the joint's linear spring.
    static_twist : float [rad]
        Twist of the linear spring under gravity.
    give, rate_give : float
        Fall of twist and of its rate at the end of a step per unit of torque there.
    period_s : float [s]
        From step to step.
    """

    stiffness: float
    static_twist: float
    give: float
    rate_give: float
    period_s: float


class JointLaw:
    """A torque between motor and link of one joint; a name for functions, never an object.

    ``solve`` is compiled.  It is asked at the end of every step for the torque N beyond the linear
    spring's when twist and rate would be e and v without it and fall by ``give`` N and
    ``rate_give`` N with it; and for the surplus, the mean torque over the step less the mean of
    its ends.  ``memory`` is its own, zero before the first step.
    """

    # Whether the static twist enters.
    preloaded: ClassVar[bool] = False
    # Which twist it sees, and while its numbers are still far off.
    sees: ClassVar[Follow] = Follow.PREDICTED
    sees_first: ClassVar[Follow] = Follow.PREDICTED
    # Whether the torque is proportional to the stiffness.
    of_spring: ClassVar[bool] = False
    solve: ClassVar[Solve]

    @staticmethod
    def constants(values: Sequence[float], lane: Lane) -> Sequence[float]:
        """Return what does not change from step to step, worked out from the law's values."""
        raise NotImplementedError
