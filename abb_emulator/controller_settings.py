"""The controller's own figures, and the errors its programs may handle."""

from dataclasses import dataclass

from modal_core.schema import setting

CYCLE_S = 0.004032
"""EGM cycle of real controllers; virtual ones have about 4 ms."""
ERROR_NUMBERS = {'ERR_UDPUC_COMM': 1001, 'ERR_OUTOFBND': 1002, 'ERR_ARGVALERR': 1003}


class RapidError(Exception):
    """An error a RAPID program's ERROR handler sees.

    Parameters
    ----------
    code : str
        Name of the error, for example ``ERR_UDPUC_COMM``.
    """

    def __init__(self, code: str) -> None:
        super().__init__(code)
        self.code = code

    @property
    def number(self) -> float:
        """ERRNO; the controller's own numbers are not published, these are the emulator's."""
        return float(ERROR_NUMBERS.get(self.code, 1000))


@dataclass(frozen=True, slots=True)
class ControllerSettings:
    """The controller's own figures.

    Parameters
    ----------
    cycle_s : float [s]
        EGM cycle; 4.000 ms on virtual controllers.
    stop_s : float [s]
        Time a program stop takes to standstill.
    manual_speed_m_s : float [m/s]
        Fastest flange in manual mode.
    following_error_deg : float [deg]
        Largest distance between command and motor.
    speed_slack : float
        Factor on the speed limits before supervision stops.
    fine_latency_s : (2,) tuple [s]
        Least and most time a program takes to go on after a fine point.
    """

    cycle_s: float = setting(CYCLE_S, 'EGM cycle [s]; 0.004 on virtual controllers', 0.001, 0.1)
    stop_s: float = setting(0.1, 'time a program stop takes to standstill [s]', 0.0, 100.0)
    manual_speed_m_s: float = setting(0.25, 'fastest flange in manual mode [m/s]', 0.0, 100.0)
    following_error_deg: float = setting(
        30.0, 'largest distance between command and motor [deg]', 0.0, 1e4
    )
    speed_slack: float = setting(
        1.05, 'factor on the speed limits before supervision stops', 1.0, 1e6
    )
    fine_latency_s: tuple[float, ...] = setting(
        (0.02, 0.06), 'least and most time to go on after a fine point [s]', 0.0, 100.0
    )
