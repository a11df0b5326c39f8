"""The demo: an emulated arm shakes itself and is identified live, then compared with its truth."""

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import socket
import time

import numpy as np
from sensor_msgs.msg import JointState

from autonomous_modal_analysis.console.terminal import MESSAGES, ProgressCallback
from autonomous_modal_analysis.demos.demonstration import DemoRun, DemoSettings, mean_of, TrueModes
from autonomous_modal_analysis.live.cell import cell_commands
from autonomous_modal_analysis.live.operator_node import OperatorNode
from autonomous_modal_analysis.live.processes import NodeCommand, NodeProcesses
from autonomous_modal_analysis.live.recorder_node import RecorderNode
from autonomous_modal_analysis.live.spinning_node import own_domain, ros_context, spinning
from excitation_planner.rapid import session_s
from modal_core.errors import RecordingError
from modal_core.nodes.ros_messages import LATCHED as LATCHED_QOS
from oma_msgs.msg import AccelerationBlock, ExcitationPlan, ModalParameters
from structural_model.robot_files import load_layout, load_robot
from structural_model.robot_writer import robot_content

IDENTIFIER = 'oma_identifier'
START_UP_S = 60.0
LOOPBACK = '127.0.0.1'
SERVICE_S = 15.0
TRUTH = 'abb_emulator/true_modes'
RECORDED = {
    '/acceleration_block': AccelerationBlock,
    '/joint_states': JointState,
    '/excitation_planner/excitation_plan': ExcitationPlan,
    '/oma_identifier/modal_parameters': ModalParameters,
    f'/{TRUTH}': ModalParameters,
}
LATCHED = (
    '/excitation_planner/excitation_plan',
    '/oma_identifier/modal_parameters',
    f'/{TRUTH}',
)


def run_demo(settings: DemoSettings, progress: ProgressCallback) -> DemoRun:
    """Start the nodes, release and start the plan, wait for the windows, stop everything.

    Raises
    ------
    ModalAnalysisError
        A node ended, the bridge refused or stopped the motion, or a result did not come.
    """
    environment = own_domain()
    port = _free_udp_port()
    commands = _commands(settings, port)
    with (
        NodeProcesses(
            [command for command in commands if command.name != IDENTIFIER],
            environment=environment,
            log_folder=settings.folder / 'log',
        ) as nodes,
        ros_context(environment) as context,
        spinning(OperatorNode(context=context)) as operator,
        _heartbeat_ends(operator),
    ):

        def check() -> None:
            nodes.check()
            operator.check_planned()

        plan = operator.wait_for('plan', lambda: operator.plan, START_UP_S, check)
        operator.wait_for(
            'robot', lambda: operator.state and operator.state.connected, START_UP_S, nodes.check
        )
        operator.wait_for(
            'plan at the bridge',
            lambda: operator.state and operator.state.plan_hash == plan.plan_hash,
            START_UP_S,
            check,
        )
        progress(0.05)
        MESSAGES.print(f'releasing and starting plan {plan.plan_hash[:12]}')
        operator.run(plan.plan_hash, f'{LOOPBACK}:{port}', SERVICE_S, nodes.check)
        # The identifier joins a moving arm, so that its first window is a full one.
        with ExitStack() as stack:
            identifier = stack.enter_context(
                NodeProcesses(
                    [command for command in commands if command.name == IDENTIFIER],
                    environment=environment,
                    log_folder=settings.folder / 'log',
                )
            )
            recorder = stack.enter_context(
                spinning(
                    RecorderNode(
                        settings.recording,
                        RECORDED,
                        LATCHED,
                        attached=robot_content(
                            load_robot(settings.robot), load_layout(settings.robot)
                        ),
                        context=context,
                    )
                )
            )
            truths: list[ModalParameters] = []
            operator.create_subscription(ModalParameters, TRUTH, truths.append, LATCHED_QOS)
            _wait_for_windows(settings, operator, recorder, (nodes, identifier), progress)
            recorder.close()
        operator.wait_for('truth', lambda: truths, SERVICE_S, nodes.check)
    progress(1.0)
    return DemoRun(
        truth=mean_of([_true_modes(message) for message in truths]),
        band_hz=(plan.band_low_hz, plan.band_high_hz),
        plan_hash=plan.plan_hash,
        window_frequencies_hz=tuple(
            np.array([mode.frequency_hz for mode in window.modes if not mode.harmonic])
            for window in operator.windows
        ),
    )


def _commands(settings: DemoSettings, port: int) -> tuple[NodeCommand, ...]:
    return cell_commands(
        # Nobody looks on.
        without=('arm_state',),
        parameters={
            'abb_emulator': {
                'robot': settings.robot,
                'start_pose': settings.pose,
                'sensor_port': port,
                'seed': settings.seed,
                # Emulator and bridge share this machine with everything else.
                'guidance.comm_timeout_s': 2.0,
                # Of any robot's plan, which is not known yet.
                'guidance.max_speed_deviation_deg_s': 30.0,
                'guidance.max_position_deviation_deg': 5.0,
                'guidance.condition_time_s': session_s(settings.excitation_s) + START_UP_S,
            },
            'robot_bridge': {
                'robot': settings.robot,
                'controller_address': LOOPBACK,
                'port': port,
                'dry_run': False,
                # Emulated time may stall with the machine; a real controller's does not.
                'link_timeout_s': 2.0,
                'most_missed_cycles': 500,
                'heartbeat_timeout_s': 2.0,
                'packet_log': str(settings.folder / 'egm.mcap'),
            },
            'excitation_planner': {
                'robot': settings.robot,
                'start_pose': settings.pose,
                'duration_s': settings.excitation_s,
                'seed': settings.seed,
            },
            IDENTIFIER: {
                'window_s': settings.window_s,
                'hop_s': settings.hop_s,
            },
        },
    )


def _wait_for_windows(
    settings: DemoSettings,
    operator: OperatorNode,
    recorder: RecorderNode,
    groups: tuple[NodeProcesses, ...],
    progress: ProgressCallback,
) -> None:
    expected_s = settings.window_s + (settings.n_windows - 1) * settings.hop_s
    start_s = time.monotonic()

    def watch() -> None:
        for group in groups:
            group.check()
        operator.check_running()
        if recorder.failure:
            raise RecordingError(recorder.failure)
        progress(0.05 + 0.85 * (time.monotonic() - start_s) / expected_s)

    operator.wait_for(
        f'{settings.n_windows} windows',
        lambda: len(operator.windows) >= settings.n_windows,
        expected_s + START_UP_S,
        watch,
    )


@contextmanager
def _heartbeat_ends(operator: OperatorNode) -> Iterator[None]:
    try:
        yield
    finally:
        operator.close()


def _true_modes(message: ModalParameters) -> TrueModes:
    return TrueModes(
        frequency_hz=np.array([mode.frequency_hz for mode in message.modes]),
        damping_ratio=np.array([mode.damping_ratio for mode in message.modes]),
        shapes=np.array(
            [np.array(mode.shape_real) + 1j * np.array(mode.shape_imag) for mode in message.modes]
        ).T,
        channel_names=tuple(message.channel_names),
        position=np.array(message.joint_positions),
    )


def _free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])
