"""One released plan while it is held, started, played; no ROS."""

from collections.abc import Callable
from dataclasses import dataclass
import time

from autonomous_modal_analysis.operating.beats import BeatReport, PERIOD_S
from autonomous_modal_analysis.operating.hold import Hold
from autonomous_modal_analysis.operating.holding import Holding
from autonomous_modal_analysis.operating.sides import Cell
from autonomous_modal_analysis.operating.situation import Situation, STATES_S
from robot_bridge.operator import FlowState

# Half of the beats' period: what is let go is in the next beat but one.
LOOK_S = PERIOD_S / 2.0
# Five beats before the start, which is refused without one.
FIRST_BEATS_S = 5.0 * PERIOD_S


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one hold.

    Parameters
    ----------
    done : bool
        The plan was played to its end.
    words : str
        What happened.
    """

    done: bool
    words: str


class HeldRun:
    """One released plan.

    Parameters
    ----------
    cell : Cell
        Where it was released.
    holding : Holding
        Where the signs of holding come from.
    token : str
        Of the release.
    """

    def __init__(self, cell: Cell, holding: Holding, token: str) -> None:
        self._cell, self._holding, self._token = cell, holding, token
        self._released_s = time.monotonic()
        self._hold: Hold = holding.begin(self._released_s)
        self._begun_s = self._started_s = self.shown_s = 0.0
        self._armed = False
        self._answer: Callable[[], tuple[bool, str] | None] | None = None
        self._asked = self._again = False

    @property
    def words(self) -> str:
        """One line of how it goes."""
        situation = self._cell.situation()
        if not self._hold.begun or situation is None:
            again = 'let go before the start, nothing moved; ' if self._again else ''
            return again + self._holding.words
        done = f'{100.0 * situation.progress:.0f} %'
        return f'{situation.state.name} {done}, {_figures(self._cell.report())}'

    def look(self, now_s: float) -> Outcome | None:
        """Take the next look; return the outcome once there is one."""
        self._holding.look(self._hold, now_s)
        situation = self._cell.situation()
        if situation is None or now_s - situation.heard_s > STATES_S:
            return Outcome(False, 'the bridge is not heard any more')
        if self._hold.over and not self._asked:
            self._hold_again(now_s)
        if self._hold.over:
            return Outcome(False, 'let go: the motion is stopped')
        if not self._hold.begun:
            return self._ended_before(situation, now_s)
        self._cell.hold(self._token, self._hold.until_s)
        if self._answer is None:
            self._begun_s = self._begun_s or now_s
            if now_s - self._begun_s > FIRST_BEATS_S:
                self._answer, self._asked = self._cell.start_later(self._token), True
            return None
        return self._follow(situation, now_s)

    def end(self) -> None:
        """Stop the beats; what was started and has not ended is stopped."""
        self._cell.let_go(self._token)
        situation = self._cell.situation()
        running = situation is None or situation.state in (FlowState.ARMED, FlowState.RUNNING)
        if running and self._asked:
            self._cell.abort()

    def _hold_again(self, now_s: float) -> None:
        """Begin a new hold under the same release, which is as recent as the bridge asks."""
        self._cell.let_go(self._token)
        self._hold = self._holding.begin(now_s)
        self._begun_s, self._again = 0.0, True

    def _ended_before(self, situation: Situation, now_s: float) -> Outcome | None:
        """Return why the release is over before anything was held."""
        self._armed = self._armed or situation.state == FlowState.ARMED
        # The state of before the release may still be on its way.
        if situation.state == FlowState.ARMED or (
            not self._armed and now_s - self._released_s < STATES_S
        ):
            return None
        return Outcome(False, f'not held: {situation.reason}')

    def _follow(self, situation: Situation, now_s: float) -> Outcome | None:
        answer = self._answer() if self._answer is not None else None
        if answer is None:
            return None
        accepted, message = answer
        if not accepted:
            self._asked = False
            return Outcome(False, f'not started: {message}')
        self._started_s = self._started_s or now_s
        moving = situation.state in (FlowState.ARMED, FlowState.RUNNING)
        if situation.heard_s < self._started_s or moving:
            return None
        done, figures = situation.state == FlowState.HOLDING, _figures(self._cell.report())
        return Outcome(done, f'{situation.state.name}: {situation.reason} ({figures})')


def _figures(beats: BeatReport) -> str:
    longest = f'longest gap {1e3 * beats.longest_s:.0f} ms'
    return f'{beats.n_beats} beats, {beats.n_late} late, {longest}'
