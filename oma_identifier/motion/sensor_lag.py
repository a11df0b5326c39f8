"""How late the stamps of a channel are."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Lag:
    """How late one channel is.

    Parameters
    ----------
    seconds, std_s : float [s]
        Against the joint states, or else the other sensors, with its standard deviation; NaN where
        that cannot be told.
    behind_s : float [s]
        Against the other sensors, as far as joint states tell; 0 where no difference is proved.
    """

    seconds: float
    std_s: float
    behind_s: float = 0.0
