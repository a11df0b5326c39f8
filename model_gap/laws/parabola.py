"""The parabola through the last three torques, where a straight line says too little."""

from modal_core.compiled import compiled
from model_gap.laws.law import Array

# Third of the give times what the spring stiffens by: beyond, no parabola follows its steps.
STEEPEST = 0.03


@compiled
def bent(memory: Array, torque: float, steep: float) -> float:
    """Return the mean over the last step less that of its ends.

    A line takes (ω h)²/12 off what may be a large part of the stiffness.  Where a step hardly
    resolves the stiffened joint the parabola would run away: the line stays.

    Parameters
    ----------
    memory : (6,) array
        Of the law: the last two torques and steeps are kept in its first four places.
    torque : float [N m]
        At the end of the step.
    steep : float
        Give times what the spring is stiffened by.
    """
    bend = max(steep, memory[2], memory[3]) / STEEPEST
    before, last = memory[0], memory[1]
    memory[0], memory[1], memory[2], memory[3] = last, torque, memory[3], steep
    return float((last + last - before - torque) / (12.0 + 12.0 * bend * bend))
