"""Where friction stood when a recording began: no model can know it, each recording's own."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from model_gap.trajectory.hysteresis import sliding
from model_gap.trajectory.term import Array, Term, TORQUE, Track, TWIST, Weight

# Ways from rest to sliding: presliding of gears is 1e-4 to 1e-3 rad.
WIDTHS_RAD = (1e-4, 1e-3)


@dataclass(frozen=True)
class StartState(Term):
    """A torque (or twist) that lasts until the axis has turned by its presliding angle."""

    type: ClassVar[str] = 'start_state'
    equation: ClassVar[str] = 'state before the first sample, forgotten as the axis slides'
    says: ClassVar[str] = 'where friction of {place} stood when a recording began'

    size: float = 1.0

    def weights(self) -> tuple[Weight, ...]:
        """Return none that recordings share."""
        return ()

    def columns(self, track: Track) -> Array:
        """Return none."""
        return np.zeros((track.motion.count, self.rows(track), 0))

    def local_columns(self, track: Track) -> Array:
        """Return what is left of the first state."""
        path = track.motion.path_rad[:, self.joint]
        left = np.column_stack([sliding(path, width)[1] for width in WIDTHS_RAD])
        return track.column(self.axis, track.motion.slow(left), self.rows(track))

    def local_scale(self) -> float:
        """Return what is plausible."""
        return self.size


@dataclass(frozen=True)
class TwistStartState(StartState):
    """The same of a twist."""

    quantity: ClassVar[str] = TWIST


def start_states(tracks: list[Track], quantity: str) -> list[StartState]:
    """Return one per row of a quantity; plausible is a third of what the row ever shows."""
    kind = StartState if quantity == TORQUE else TwistStartState
    motions = [item.motion for item in tracks]
    shown = np.concatenate(
        [item.torque_nm if quantity == TORQUE else item.twist_rad for item in motions]
    )
    joints = range(shown.shape[1]) if quantity == TORQUE else motions[0].encoders
    return [
        kind('start', row, joint, size=max(0.3 * float(np.ptp(shown[:, row])), 1e-12))
        for row, joint in enumerate(joints)
    ]
