"""The MAC of two estimates of one mode that their uncertainty makes to be expected.

Errors along a shape change its scale alone; errors e across it, as shares of its length, lower the
MAC with the true shape to 1 / (1 + |e|²).  |e|² is a sum of squares of Gaussian variables, which a
gamma distribution of the same mean and variance describes.
"""

from dataclasses import dataclass
import math

from scipy.special import gammainccinv

from modal_core.mode import Mode

THREE_SIGMA = 0.00135
"""Normal probability below -3 standard deviations."""


@dataclass(frozen=True, slots=True)
class ExpectedMac:
    """What chance leaves of the MAC of two estimates of one mode; NaN when not known.

    Parameters
    ----------
    mean : float
        On average.
    least : float
        Three standard deviations below: chance alone gives less in 0.135 % of cases.
    """

    mean: float
    least: float


UNKNOWN = ExpectedMac(math.nan, math.nan)


def expected_mac(first: Mode, second: Mode) -> ExpectedMac:
    """Return the MAC to be expected of two independent estimates, if of one mode.

    Their errors are taken to lie in the same directions, as those of the same mode seen by the
    same channels do: then not only the means add but the standard deviations, too.

    References
    ----------
    Greś, Döhler and Mevel, Uncertainty quantification of the Modal Assurance Criterion in
    Operational Modal Analysis, hal-03276725.
    """
    mean = first.mac_loss + second.mac_loss
    std = first.mac_loss_std + second.mac_loss_std
    if not (mean > 0.0 and std > 0.0):
        return UNKNOWN
    form = (mean / std) ** 2
    most = mean / form * float(gammainccinv(form, THREE_SIGMA))
    return ExpectedMac(1.0 / (1.0 + mean), 1.0 / (1.0 + most))
