"""What the page shows, out of messages; a message that makes no sense is a ValueError."""

from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
from numpy.typing import NDArray

from modal_dashboard.screens import (
    BridgeNews,
    Check,
    CheckStep,
    Diagram,
    PlanNews,
    pole_table,
)
from modal_reports import Spectrum
from oma_msgs.msg import BridgeState, ExcitationPlan, StabilisationDiagram

MOST_POLES = 100_000
STATES = {
    getattr(BridgeState, name): name.lower()
    for name in (
        'DISCONNECTED', 'IDLE', 'ARMED', 'RUNNING', 'STOPPING', 'HOLDING', 'ABORTED',
    )
}  # fmt: skip


def diagram(message: StabilisationDiagram) -> Diagram:
    """Return poles and spectrum.

    Raises
    ------
    ValueError
        Nothing that an identifier sends.
    """
    if len(message.frequency_hz) > MOST_POLES:
        raise ValueError(f'more than {MOST_POLES} poles')
    poles = pole_table(
        _floats(message.frequency_hz),
        _floats(message.damping_ratio),
        np.asarray(message.model_order, dtype=np.int64),
        np.asarray(message.status, dtype=np.uint8),
        np.asarray(message.mode_id, dtype=np.int64),
    )
    frequency_hz = _floats(message.spectrum_frequency_hz)
    values = _floats(message.spectrum_singular_value)
    spectrum = Spectrum(frequency_hz, values.reshape(len(frequency_hz), -1)[:, :16])
    if len(frequency_hz) and not (np.diff(frequency_hz) > 0.0).all():
        raise ValueError('frequencies of a spectrum that do not ascend')
    return Diagram(message.window_index, poles, spectrum)


def bridge_news(message: BridgeState) -> BridgeNews:
    """Return the state of the bridge."""
    told = {name: getattr(message, name) for name in BridgeNews.__dataclass_fields__}
    return BridgeNews(**{**told, 'state': STATES.get(message.state, str(message.state))})


def plan_news(message: ExcitationPlan) -> PlanNews:
    """Return what a plan says of itself."""
    return PlanNews(**{name: getattr(message, name) for name in PlanNews.__dataclass_fields__})


def check(status: DiagnosticStatus) -> Check:
    """Return one check."""
    level: Any = status.level
    step = level[0] if isinstance(level, bytes) else int(level)
    values = {pair.key: pair.value for pair in status.values}
    return Check(status.name, CheckStep(min(step, max(CheckStep))), status.message, values)


def _floats(values: Any) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64)
