"""The controller's own figures, and the errors its programs may handle."""

from dataclasses import dataclass

from modal_core.settings.schema import setting

CYCLE_S = 0.004032
"""EGM cycle of real controllers; virtual ones have about 4 ms."""
ERROR_NUMBERS = {'ERR_UDPUC_COMM': 1001, 'ERR_OUTOFBND': 1002, 'ERR_ARGVALERR': 1003}

OPTIONS = EGM_OPTION, COLLISION_OPTION = (
    '689-1 Externally Guided Motion',
    '613-1 Collision Detection',
)
NOT_CONNECTED = 9e9
"""RAPID's value of an external axis that is not there."""


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
    external : (6,) tuple [mm] or [deg]
        Places of the external axes a to f; 9E9 is one that is not there.
    signals : str
        Digital outputs of the configuration, separated by commas.
    system_data : str
        Tools, work objects and loads that other modules declare, separated by commas.
    unit, device : str
        Mechanical unit and UDPUC device of the configuration.
    guided_motion, collision_detection : bool
        Options 689-1 and 613-1: without them no module with their instructions loads.
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
    external: tuple[float, ...] = setting(
        (NOT_CONNECTED,) * 6, 'places of the external axes a to f; 9e9: not there'
    )
    signals: str = setting('doAmaRun', 'digital outputs, separated by commas')
    system_data: str = setting('tool0,wobj0,load0', 'tools, work objects, loads of other modules')
    unit: str = setting('ROB_1', 'mechanical unit')
    device: str = setting('UCdevice', 'UDPUC device')
    guided_motion: bool = setting(True, 'option 689-1, Externally Guided Motion')
    collision_detection: bool = setting(True, 'option 613-1, Collision Detection')

    @property
    def options(self) -> tuple[str, ...]:
        """Names of the options there are."""
        there = (self.guided_motion, self.collision_detection)
        return tuple(name for name, has in zip(OPTIONS, there, strict=True) if has)


def names_in(text: str) -> tuple[str, ...]:
    """Return names separated by commas."""
    return tuple(name.strip() for name in text.split(',') if name.strip())
