"""Corner of a high-pass of first order."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Corner:
    """Corner of a high-pass.

    Parameters
    ----------
    hz, std_hz : float [Hz]
    sure : bool
        Whether it is larger than chance makes it.
    """

    hz: float
    std_hz: float
    sure: bool


NO_CORNER = Corner(0.0, float('inf'), sure=False)
