"""What a torque law is: solved implicitly, step by step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# (constants, memory, twist, rate, motor speed) to the torque and the surplus: laws/solve.py.
Torque = Callable[..., tuple[float, float]]
# Numbers a law keeps from step to step.
MEMORY = 4


class Follow(Enum):
    """Which twist a law is evaluated on."""

    PREDICTED = 'predicted'
    PARTED = 'measured above a few hertz, predicted below'
    MEASURED = 'measured'


@dataclass(frozen=True)
class JointContext:
    """The joint of one record that a torque acts in.

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
    start_s : float [s]
        When the record begins, from the beginning of the campaign.
    damping : float [N m s/rad]
        Of the joint's linear damper.
    """

    stiffness: float
    static_twist: float
    give: float
    rate_give: float
    period_s: float
    start_s: float = 0.0
    damping: float = 0.0

    def yielding(self, compliance: float) -> float:
        """Return p/2hk of a spring before sliding, p as a share of the joint's own compliance."""
        return 0.5 * compliance / (self.period_s * self.stiffness)


class JointLaw:
    """A torque between motor and link of one joint; used as a class, never instantiated.

    ``torque`` is its equation solved, machine code as in ``laws/solve.py``, and ``constants`` are
    what that takes.
    """

    torque: ClassVar[Torque]
    # Which twist it sees, and while it is only screened.
    sees: ClassVar[Follow] = Follow.PREDICTED
    sees_screened: ClassVar[Follow] = Follow.PREDICTED
    # Whether it is the spring's: proportional to the stiffness, and twisted by gravity.
    of_spring: ClassVar[bool] = False

    @staticmethod
    def constants(values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return what does not change from step to step, worked out from the law's values."""
        raise NotImplementedError


class SpringLaw(JointLaw):
    """A torque that the joint's own spring makes, the share of gravity's twist its last value."""

    sees_screened = Follow.MEASURED
    of_spring = True
