"""How far a campaign confirms the springs of gears that it names nothing wrong with."""

from dataclasses import dataclass
import math

import numpy as np

from model_gap.trajectory.term import Array
from model_gap.trajectory.twist_terms import JointStiffness

# Standard deviations: 19 of 20 springs are nearer to the model's than is told.
SURE = 2.0
# A spring a quarter off moves the frequency it governs by an eighth: what is told no better is
# not confirmed.  Chosen, not measured.
WELL = 0.25


@dataclass(frozen=True)
class GearTold:
    """What is told of one gear.

    Parameters
    ----------
    row : str
        Its axis.
    joint : str
        Its joint.
    model : float [N m/rad]
        The model's stiffness; infinite without a spring.
    stiffness, sigma : float [N m/rad]
        As the campaign has it; negative where noise outweighs the model's spring.
    least : float [N m/rad]
        It is stiffer than that, in 19 of 20 cases.
    within : float
        By which share of the model's compliance it differs at most, in 19 of 20 cases.
    load_nm : float [N m]
        How much its load varies, rms.
    """

    row: str
    joint: str
    model: float
    stiffness: float
    sigma: float
    least: float
    within: float
    load_nm: float

    @property
    def confirmed(self) -> bool:
        """Whether the model's spring is the arm's, as well as that is of use."""
        return self.within <= WELL


def gear_told(
    term: JointStiffness, row: str, weights: Array, covariance: Array, load: Array
) -> GearTold:
    """Return what weights of a gear's further compliance tell of it.

    Parameters
    ----------
    term : JointStiffness
        Of the gear.
    row : str
        Its axis.
    weights : (1,) array [rad/(N m)]
        Further compliance, fitted beside the laws that were found.
    covariance : (1, 1) array
        Of it.
    load : (n,) array [N m]
        Of the gear in all recordings.
    """
    compliance = term.compliance(weights)
    sigma = math.sqrt(max(term.variance(weights, covariance), 0.0))
    most = abs(float(weights[0])) + SURE * sigma
    return GearTold(
        row=row,
        joint=term.location,
        model=term.model_stiffness,
        stiffness=1.0 / compliance,
        sigma=sigma / compliance**2,
        least=1.0 / (1.0 / term.model_stiffness + most),
        within=most * term.model_stiffness,
        load_nm=float(np.std(load)),
    )
