"""States and limits of the operator flow."""

from dataclasses import dataclass, field
from enum import IntEnum

from modal_core.errors import BridgeError
from modal_core.settings.schema import setting
from robot_bridge.egm import MCI_RUNNING, RobotFeedback
from robot_bridge.player import PlayerSettings


class FlowState(IntEnum):
    """States of the bridge; the numbers of oma_msgs/BridgeState."""

    DISCONNECTED = 0
    IDLE = 1
    ARMED = 2
    RUNNING = 3
    STOPPING = 4
    HOLDING = 5
    ABORTED = 6


@dataclass(frozen=True, slots=True)
class FlowSettings:
    """Limits of the operator flow.

    Parameters
    ----------
    cycle_s : float [s]
        Period of the controller.
    link_timeout_s : float [s]
        Silence after which the link counts as lost.
    most_missed_cycles : int
        Packets in a row that may be missing while moving.
    heartbeat_timeout_s : float [s]
        Silence of the operator's heartbeat that stops the motion; 0 asks for no heartbeat.
    start_tolerance_deg : float [deg]
        Largest distance of any axis from the start pose at ``start``.
    max_following_error_deg : float [deg]
        Largest distance of the measured from the wanted axis angle; what the plan allows is less.
    dry_run : bool
        Go through everything and send nothing.
    player : PlayerSettings
        Ramps.
    """

    cycle_s: float = setting(0.004032, 'period of the controller [s]', 0.001, 0.1)
    link_timeout_s: float = 0.012
    most_missed_cycles: int = setting(
        3, 'packets in a row that may be missing while moving', 0, 10_000
    )
    heartbeat_timeout_s: float = setting(
        0.13, 'silence of the operator that stops; 0: none asked, emulator only [s]', 0.0, 10.0
    )
    start_tolerance_deg: float = setting(
        0.2, 'distance from the start pose allowed at start [deg]', 0.0, 5.0
    )
    max_following_error_deg: float = setting(
        2.0, 'distance from the reference that stops [deg]', 0.01, 90.0
    )
    dry_run: bool = setting(True, 'go through everything and send nothing to the controller')
    player: PlayerSettings = field(default_factory=PlayerSettings)


def check_fraction(fraction: float) -> None:
    """Refuse a speed override that is not within 0..1.

    Raises
    ------
    BridgeError
        It is not.
    """
    if not 0.0 <= fraction <= 1.0:
        raise BridgeError('bad speed_override', found=fraction, expected='0..1')


def not_ready(feedback: RobotFeedback) -> str:
    """Return why the controller would not follow; empty when it would."""
    if not feedback.motors_on:
        return 'motors are off'
    if feedback.mci_state != MCI_RUNNING:
        return f'the EGM session is {feedback.mci_name}'
    if not feedback.rapid_running:
        return 'the RAPID program is not running'
    return ''
