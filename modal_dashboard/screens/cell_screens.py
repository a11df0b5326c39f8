"""What the page says of bridge and planner; it only looks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

from modal_dashboard.screens.board import Update
from modal_dashboard.screens.plain_tables import plain_table
from modal_reports import (
    fixed,
    FREQUENCY,
    number,
    percent,
    Row,
    significant,
    Table,
    UNKNOWN,
)

HASH_LETTERS = 12
ABORTED, SILENT = 'aborted', 'silent'
SILENT_S = 3.0
"""A bridge tells its state ten times a second and promises to within three."""


@dataclass(frozen=True, slots=True)
class BridgeNews:
    """State of the bridge: fields of oma_msgs/BridgeState, ``state`` as a word."""

    state: str
    backend: str
    controller: str
    dry_run: bool
    reason: str
    plan_hash: str
    progress: float
    speed_override: float
    connected: bool
    motors_on: bool
    controller_state: str
    n_received: int
    n_rejected: int
    n_missed_cycles: int
    reply_latency_p99_s: float

    @property
    def is_bad(self) -> bool:
        """Whether a person should know."""
        return self.state in (ABORTED, SILENT)

    @property
    def words(self) -> str:
        """State and why it was entered."""
        return f'{self.state}: {self.reason}' if self.reason else self.state

    def silent(self) -> 'BridgeNews':
        """Return that nothing is known any more: what it last said may be wrong by now."""
        reason = f'not heard for {SILENT_S:.0f} s; before: {self.words}'
        return replace(self, state=SILENT, reason=reason, connected=False, motors_on=False)

    def update(self) -> Update:
        """Return what the page says of it."""
        entries = [
            ['State', self.state],
            ['Why', self.reason or UNKNOWN],
            ['Dry run', 'yes: nothing is sent to the controller' if self.dry_run else 'no'],
            ['Controller', f'{self.controller or UNKNOWN} ({self.backend})'],
            ['Connected', _yes(self.connected)],
            ['Motors on', _yes(self.motors_on)],
            ['State of the controller', self.controller_state or UNKNOWN],
            ['Plan', self.plan_hash[:HASH_LETTERS] or 'none'],
            ['Played', percent(self.progress, 0)],
            ['Speed override', percent(self.speed_override, 0)],
            ['Packets taken', str(self.n_received)],
            ['Packets refused', str(self.n_rejected)],
            ['Cycles missed', str(self.n_missed_cycles)],
            ['Reply within (99 %)', f'{fixed(1e3 * self.reply_latency_p99_s, 2)} ms'],
        ]
        if self.state == SILENT:
            entries = entries[:2]
        progress = self.progress if math.isfinite(self.progress) else 0.0
        return Update.of('bridge', {'entries': entries, 'progress': progress, 'bad': self.is_bad})


@dataclass(frozen=True, slots=True)
class PlanNews:
    """A plan: fields of oma_msgs/ExcitationPlan."""

    plan_hash: str
    robot_name: str
    signal: str
    duration_s: float
    band_low_hz: float
    band_high_hz: float
    peak_point_speed: float
    torque_projection_rank: int
    mode_frequency_hz: Sequence[float]
    mode_signal_to_noise_db: Sequence[float]

    @property
    def words(self) -> str:
        """What came."""
        return f'plan {self.plan_hash[:HASH_LETTERS]}: {significant(self.duration_s)} s'

    def update(self) -> Update:
        """Return what the page says of it."""
        band = f'{significant(self.band_low_hz)} to {significant(self.band_high_hz)} Hz'
        entries = [
            ['Plan', self.plan_hash[:HASH_LETTERS]],
            ['Robot', self.robot_name],
            ['Signal', self.signal.replace('_', ' ')],
            ['Duration', f'{significant(self.duration_s)} s'],
            ['Band', band],
            ['Fastest point', f'{significant(self.peak_point_speed)} m/s'],
            ['Rank of the torques', str(self.torque_projection_rank)],
        ]
        return Update.of('plan', {'entries': entries, 'modes': plain_table(self._modes())})

    def _modes(self) -> Table:
        pairs = zip(self.mode_frequency_hz, self.mode_signal_to_noise_db, strict=False)
        rows = [
            Row((number(FREQUENCY.number(at_hz)), number(fixed(ratio_db, 0))))
            for at_hz, ratio_db in pairs
        ]
        heads = (number('Frequency [Hz]'), number('Signal to noise [dB]'))
        return Table('Expected modes', heads, rows)


def _yes(holds: bool) -> str:
    return 'yes' if holds else 'no'
