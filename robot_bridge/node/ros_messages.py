"""State, joints and diagnostics of the bridge as ROS messages; the header is the publisher's."""

from array import array
from collections.abc import Sequence
import math
import time

from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import JointState

from modal_core.nodes.ros_messages import diagnostic, stamp
from oma_msgs.msg import BridgeState
from robot_bridge.bridge import Bridge
from robot_bridge.operator import FlowState

LEVELS = {
    FlowState.DISCONNECTED: DiagnosticStatus.WARN,
    FlowState.ABORTED: DiagnosticStatus.ERROR,
}

RECENT_S = 5.0


def joint_state(
    names: Sequence[str],
    stamp_ns: int,
    position: NDArray[np.float64],
    velocity: NDArray[np.float64] | None = None,
) -> JointState:
    """Return joint angles [rad] and, where known, speeds [rad/s] at a time [ns]."""
    message = JointState(name=names)
    message.header.stamp = stamp(stamp_ns)
    message.position = array('d', position.tobytes())
    if velocity is not None:
        message.velocity = array('d', velocity.tobytes())
    return message


def state_message(bridge: Bridge | None, name: str, condition: str) -> BridgeState:
    """Return the state; ``condition`` says why the bridge cannot be armed, empty when it can."""
    if bridge is None:
        nan = math.nan
        return BridgeState(
            backend=name, reason=condition, reply_latency_p50_s=nan, reply_latency_p99_s=nan
        )
    flow, link = bridge.flow, bridge.link
    latency, feedback, path = link.latency.summary(), flow.feedback, flow.path
    reasons = (condition, flow.reason, _refused(bridge), flow.away)
    return BridgeState(
        backend=name,
        controller=bridge.settings.controller,
        state=int(flow.state),
        dry_run=flow.settings.dry_run,
        reason='; '.join(part for part in reasons if part),
        plan_hash=path.plan_hash if path else '',
        progress=flow.progress,
        speed_override=flow.speed_override,
        connected=flow.connected,
        motors_on=feedback.motors_on if feedback else False,
        controller_state=feedback.mci_name if feedback else 'undefined',
        n_received=link.n_received,
        n_sent=link.n_sent,
        n_rejected=link.check.counts['rejected'],
        n_missed_cycles=link.check.counts['missed_cycles'],
        reply_latency_p50_s=latency.p50_s,
        reply_latency_p99_s=latency.p99_s,
    )


def diagnostic_status(
    name: str, bridge: Bridge | None, plan_error: str, clash: str = ''
) -> DiagnosticStatus:
    """Return the diagnostics; the worst that is wrong gives the code."""
    if bridge is None and clash:
        return diagnostic(name, f'NAME_CLASH {clash}', DiagnosticStatus.ERROR)
    if bridge is None:
        return diagnostic(name, 'BRIDGE_NOT_CONFIGURED', DiagnosticStatus.WARN)
    flow, link, log = bridge.flow, bridge.link, bridge.log
    level = LEVELS.get(flow.state, DiagnosticStatus.OK)
    code = f'BRIDGE_{flow.state.name}'
    if time.monotonic() - flow.release.foreign_s < RECENT_S:
        level, code = max(level, DiagnosticStatus.WARN), 'FOREIGN_HEARTBEAT'
    if plan_error:
        level, code = DiagnosticStatus.ERROR, f'PLAN_REFUSED {plan_error}'
    if log is not None and log.failure:
        level, code = DiagnosticStatus.ERROR, f'PACKET_LOG_STOPPED {log.failure}'
    if clash:
        level, code = DiagnosticStatus.ERROR, f'NAME_CLASH {clash}'
    latency = link.latency.summary()
    values: dict[str, object] = {
        'reason': flow.reason,
        'active': flow.active,
        'dry_run': flow.settings.dry_run,
        'controller': bridge.settings.controller,
        'foreign_heartbeats': flow.release.n_foreign,
        'real_time_priority': link.real_time,
        'received': link.n_received,
        'sent': link.n_sent,
        'reply_latency_p50_ms': _milliseconds(latency.p50_s),
        'reply_latency_p99_ms': _milliseconds(latency.p99_s),
        'reply_latency_max_ms': _milliseconds(latency.max_s),
        'missed_cycles': 0,
        **link.check.counts,
        'last_refusal': link.last_refusal,
    }
    if log is not None:
        values |= {
            'log_file': log.path,
            'logged': log.n_written,
            'lost_to_log': log.n_lost,
            'log_files_deleted': log.n_files_deleted,
            'log_failure': log.failure,
        }
    return diagnostic(name, code, level, values)


def _refused(bridge: Bridge) -> str:
    """Say why nothing is heard of a controller that does send; empty when it is heard."""
    refusal = bridge.link.refusal
    return f'its packets are refused: {refusal}' if refusal and not bridge.flow.connected else ''


def _milliseconds(seconds: float) -> str:
    return f'{1e3 * seconds:.3f}' if math.isfinite(seconds) else 'none'
