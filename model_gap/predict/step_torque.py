"""Nonlinear torque of one joint in one record: exact linear steps in modal form, implicit torque.

The twist of a joint is that of the linear arm, found by Fourier transform, plus the response to
the torque, stepped mode by mode.  Only the torque comes out; it enters the linear prediction as a
further force, so that sensors, poses and leakage are treated as for any other force.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from model_gap.cell import JointForce
from model_gap.laws import JointContext, JointLaw, stepped
from model_gap.predict.joint_path import JointPath
from model_gap.predict.ring_out import summed

Array = NDArray[np.float64]


def step_torque(path: JointPath, force: JointForce) -> Array:
    """Step the torque along a path.

    Returns
    -------
    (n_steps,) array [N m]
        Torque of the law on the twist, mean from each step to the next; the arm feels its
        negative.

    References
    ----------
    Exact step of a modal state under a force linear between steps: Van Loan (1978),
    doi:10.1109/TAC.1978.1101743.
    """
    period = 1.0 / path.steps_per_s
    poles, residues = path.poles, path.residues
    grow = np.exp(poles * period)
    now = (grow - 1.0) / poles
    change = (now / period - 1.0) / poles
    give = float((residues @ change).real) + path.instant
    rate_give = float((residues * poles @ change).real)
    context = JointContext(
        stiffness=path.stiffness,
        static_twist=path.static_twist,
        give=give,
        rate_give=max(rate_give, 1e-3 * give / period),
        period_s=period,
        start_s=path.start_s,
        damping=path.damping,
    )
    constants = np.array(force.law.constants(force.values, context), dtype=float)
    # The state without the present torque: y' = g y - (g change + held) N.
    modes = np.array([residues, residues * poles, grow, now, grow * change + now - change])
    return stepped(force.law.torque, constants, modes, path.twist, path.rate, path.speed)


def compile_laws() -> None:
    """Compile every law and what steps it, so that forked processes find them."""
    nothing, still = np.zeros((5, 1), dtype=complex), np.zeros(2)
    for law in _laws(JointLaw):
        stepped(law.torque, np.ones(16), nothing, still, still, still)
    summed(still, nothing[0])


def _laws(kind: type[JointLaw]) -> Iterator[type[JointLaw]]:
    """Yield all laws there are, those of users' own effects included."""
    for law in kind.__subclasses__():
        if hasattr(law, 'torque'):
            yield law
        yield from _laws(law)
