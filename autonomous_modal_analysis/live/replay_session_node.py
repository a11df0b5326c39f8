"""A recording played through the live identifier, and the windows that come back."""

from collections.abc import Callable
from dataclasses import dataclass
import time
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from autonomous_modal_analysis.live.cell import parameter_file
from autonomous_modal_analysis.live.operator_node import RESULTS
from autonomous_modal_analysis.live.processes import NodeCommand, NodeProcesses
from autonomous_modal_analysis.live.spinning_node import own_domain, ros_context, spinning
from modal_core.errors import BridgeError
from modal_core.work.progress import Progress
from oma_msgs.msg import BridgeState, ModalParameters

POLL_S = 0.05
START_UP_S = 60.0
FINISH_S = 600.0
IDENTIFIER = 'oma_identifier'
REPLAY = 'replay'


@dataclass(frozen=True, slots=True)
class ReplaySettings:
    """What is played and how it is identified.

    Parameters
    ----------
    replay_parameters, identifier_parameters : dict
        ROS parameters of the two nodes.
    duration_s : float [s]
        Of the recording at the chosen rate; 0 when it is looped.
    """

    replay_parameters: dict[str, object]
    identifier_parameters: dict[str, object]
    duration_s: float


class ListenerNode(Node):
    """Collects the windows the identifier publishes, and watches the replay."""

    def __init__(self, on_window: Callable[[ModalParameters], None], **options: Any) -> None:
        super().__init__('ama_listener', **options)
        self.n_windows = 0
        self.state: BridgeState | None = None
        self._on_window = on_window
        self.create_subscription(
            ModalParameters, f'{IDENTIFIER}/modal_parameters', self._take, RESULTS
        )
        self.create_subscription(BridgeState, f'{REPLAY}/state', self._note, 10)
        self.finish = self.create_client(Trigger, f'{IDENTIFIER}/finish')

    def _take(self, message: ModalParameters) -> None:
        self.n_windows += 1
        self._on_window(message)

    def _note(self, message: BridgeState) -> None:
        self.state = message


def play_only(settings: ReplaySettings, on_progress: Progress) -> None:
    """Play a recording into the ROS domain of this shell, and nothing else.

    Raises
    ------
    ModalAnalysisError
        The recording cannot be played.
    """
    with NodeProcesses([_replay_command(settings)]) as nodes:
        _wait_for_end(nodes, settings, on_progress)


def replay(
    settings: ReplaySettings,
    on_window: Callable[[ModalParameters], None],
    on_progress: Progress,
) -> int:
    """Play a recording through an identifier in an own ROS domain; return how many windows came.

    Parameters
    ----------
    settings : ReplaySettings
        What and how.
    on_window, on_progress : callable
        Told every window, and the fraction played.

    Raises
    ------
    ModalAnalysisError
        A node ended, or the recording cannot be played.
    """
    environment = own_domain()
    identifier = NodeCommand(
        name=IDENTIFIER,
        module='oma_identifier.node.identifier_node',
        parameter_file=parameter_file(IDENTIFIER),
        parameters=settings.identifier_parameters,
    )
    with (
        ros_context(environment) as context,
        spinning(ListenerNode(on_window, context=context)) as listener,
        NodeProcesses([identifier], environment=environment) as identifiers,
    ):
        _wait(listener.finish.service_is_ready, 'identifier', START_UP_S, identifiers.check)
        with NodeProcesses([_replay_command(settings)], environment=environment) as player:
            _wait_for_end(player, settings, on_progress)
        done = listener.finish.call_async(Trigger.Request())
        _wait(done.done, 'last window', FINISH_S, identifiers.check)
        # The service may answer before the last window has come over its own topic.
        time.sleep(0.5)
        return listener.n_windows


def _replay_command(settings: ReplaySettings) -> NodeCommand:
    return NodeCommand(
        name=REPLAY,
        module='robot_bridge.node.replay_node',
        parameters=settings.replay_parameters,
    )


def _wait_for_end(player: NodeProcesses, settings: ReplaySettings, on_progress: Progress) -> None:
    start_s = time.monotonic()
    while not player.ended_well(REPLAY):
        if settings.duration_s > 0.0:
            on_progress((time.monotonic() - start_s) / settings.duration_s)
        time.sleep(POLL_S)


def _wait(
    ready: Callable[[], bool], what: str, timeout_s: float, check: Callable[[], None]
) -> None:
    deadline = time.monotonic() + timeout_s
    while not ready():
        check()
        if time.monotonic() > deadline:
            raise BridgeError(f'no {what} within {timeout_s:g} s')
        time.sleep(POLL_S)
