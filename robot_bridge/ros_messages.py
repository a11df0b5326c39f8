"""State and diagnostics of the bridge as ROS messages; the header is the publisher's."""

import math

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from oma_msgs.msg import BridgeState
from robot_bridge.backend import Backend
from robot_bridge.egm_link import EgmLink
from robot_bridge.operator_flow import FlowState
from robot_bridge.packet_log import PacketLog


def state_message(
    backend: Backend | None, link: EgmLink | None, name: str, condition: str
) -> BridgeState:
    """Return the state; ``condition`` says why the bridge cannot be armed, empty when it can."""
    if backend is None or link is None:
        nan = math.nan
        return BridgeState(
            backend=name, reason=condition, reply_latency_p50_s=nan, reply_latency_p99_s=nan
        )
    flow, counts = backend.flow, link.check.counts
    latency, feedback = link.latency.summary(), flow.feedback
    return BridgeState(
        backend=name,
        state=int(flow.state),
        dry_run=flow.settings.dry_run,
        reason='; '.join(part for part in (condition, flow.reason) if part),
        plan_hash=flow.path.plan_hash if flow.path else '',
        progress=flow.progress,
        speed_override=flow.speed_override,
        connected=flow.connected,
        motors_on=feedback.motors_on if feedback else False,
        controller_state=feedback.mci_name if feedback else 'undefined',
        n_received=link.n_received,
        n_sent=link.n_sent,
        n_rejected=counts['rejected'],
        n_missed_cycles=counts['missed_cycles'],
        reply_latency_p50_s=latency.p50_s,
        reply_latency_p99_s=latency.p99_s,
    )


def diagnostic_status(
    backend: Backend | None, link: EgmLink | None, log: PacketLog | None, plan_error: str
) -> DiagnosticStatus:
    """Return the diagnostics; the worst that is wrong gives the code."""
    if backend is None or link is None:
        return DiagnosticStatus(level=DiagnosticStatus.WARN, message='BRIDGE_NOT_CONFIGURED')
    flow = backend.flow
    status = DiagnosticStatus(level=DiagnosticStatus.OK, message=f'BRIDGE_{flow.state.name}')
    if flow.state == FlowState.DISCONNECTED:
        status.level = DiagnosticStatus.WARN
    if flow.state == FlowState.ABORTED:
        status.level = DiagnosticStatus.ERROR
    if plan_error:
        status.level, status.message = DiagnosticStatus.ERROR, f'PLAN_REFUSED {plan_error}'
    if log is not None and log.failure:
        status.level, status.message = DiagnosticStatus.ERROR, f'PACKET_LOG_STOPPED {log.failure}'
    latency = link.latency.summary()
    values: dict[str, object] = {
        'reason': flow.reason,
        'active': flow.active,
        'dry_run': flow.settings.dry_run,
        'real_time_priority': link.real_time,
        'received': link.n_received,
        'sent': link.n_sent,
        'reply_latency_p50_ms': _milliseconds(latency.p50_s),
        'reply_latency_p99_ms': _milliseconds(latency.p99_s),
        'reply_latency_max_ms': _milliseconds(latency.max_s),
        **link.check.counts,
    }
    if log is not None:
        values |= {
            'logged': log.n_written,
            'lost_to_log': log.n_lost,
            'log_failure': log.failure,
        }
    status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    return status


def _milliseconds(seconds: float) -> str:
    return f'{1e3 * seconds:.3f}' if math.isfinite(seconds) else 'none'
