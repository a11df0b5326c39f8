"""Which packets belong to the session: one peer, rising numbers, no jumps.

A packet that contradicts the ones before it is set aside until the next one goes on from it: one
that was damaged or forged neither moves the reference nor makes the ones after it look old.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from robot_bridge.egm.egm_feedback import Joints, RobotFeedback

Address = tuple[str, int]
UINT32 = 1 << 32
# More cycles than this in one step are believed only if the controller's clock moved with them.
FEW_CYCLES = 4
MILLISECONDS = 1000.0


class Verdict(Enum):
    """What to do with a packet."""

    ACCEPT = 'accept'
    NEW_SESSION = 'new_session'
    IGNORE = 'ignore'
    ALARM = 'alarm'


@dataclass(frozen=True, slots=True)
class Judgement:
    """A verdict and its reason.

    Parameters
    ----------
    verdict : Verdict
        What to do.
    reason : str
        Stable code of what was found, empty for an ordinary packet.
    n_steps : int
        Cycles since the packet before; 1 without a loss.
    """

    verdict: Verdict
    reason: str = ''
    n_steps: int = 1


ACCEPTED = Judgement(Verdict.ACCEPT)


@dataclass(frozen=True, slots=True)
class SessionLimits:
    """What a session may do.

    Parameters
    ----------
    cycle_s : float [s]
        Nominal period of the packets.
    max_speed_deg_s : (6,) tuple [deg/s]
        Fastest each axis can move.
    jump_slack_deg : float [deg]
        Added to the largest believable step: noise, rounding.
    silence_s : float [s]
        After this long without a packet a session that starts again is believed; packets are not
        delayed by more.
    controller_address : str
        The only host that is listened to; empty takes the first one that speaks.
    """

    cycle_s: float = 0.004032
    max_speed_deg_s: Sequence[float] = (200.0,) * 6
    jump_slack_deg: float = 0.05
    silence_s: float = 0.25
    controller_address: str = ''


class SessionCheck:
    """Judges the packets of one socket.

    Parameters
    ----------
    limits : SessionLimits
        What is believed.
    """

    def __init__(self, limits: SessionLimits) -> None:
        self.limits = limits
        self.counts: Counter[str] = Counter()
        self.peer: Address | None = None
        self._last: RobotFeedback | None = None
        self._doubted: RobotFeedback | None = None
        self._heard_s = 0.0

    def sender(self, address: Address, now_s: float) -> Judgement:
        """Judge who a datagram is from, before its content is looked at."""
        wanted = self.limits.controller_address
        if wanted and address[0] != wanted:
            return self._refuse(Verdict.ALARM, 'foreign_sender')
        if self.peer is None or address == self.peer:
            return ACCEPTED
        silent = now_s - self._heard_s > self.limits.silence_s
        if silent and address[0] == self.peer[0]:
            return ACCEPTED  # the controller came back on another port
        return self._refuse(Verdict.ALARM, 'second_sender')

    def feedback(self, feedback: RobotFeedback, address: Address, now_s: float) -> Judgement:
        """Judge a decoded packet and, when it is accepted, remember it."""
        judgement = self._compare(feedback, address, now_s)
        if judgement.verdict not in (Verdict.ACCEPT, Verdict.NEW_SESSION):
            return judgement
        doubt, confirmed = self._doubt(feedback, judgement, now_s), self._goes_on(feedback)
        self._doubted = feedback if doubt and not confirmed else None
        if self._doubted is not None:
            alarming = doubt == 'joint_jump'
            return self._refuse(Verdict.ALARM if alarming else Verdict.IGNORE, doubt)
        self._last, self.peer, self._heard_s = feedback, address, now_s
        self.counts['missed_cycles'] += judgement.n_steps - 1
        return judgement

    def refuse_content(self) -> Judgement:
        """Note a datagram that could not be decoded."""
        return self._refuse(Verdict.IGNORE, 'malformed')

    def refuse_stale(self) -> Judgement:
        """Note a packet that waited too long to be worth an answer; it counts as missed."""
        self.counts['stale'] += 1
        return Judgement(Verdict.IGNORE, 'stale')

    def _compare(self, feedback: RobotFeedback, address: Address, now_s: float) -> Judgement:
        last = self._last
        if last is None:
            return Judgement(Verdict.NEW_SESSION, 'first_packet')
        silent = now_s - self._heard_s > self.limits.silence_s
        if address != self.peer:
            return Judgement(Verdict.NEW_SESSION, 'new_port')
        n_steps = (feedback.seqno - last.seqno) % UINT32
        passed_ms = (feedback.tm_ms - last.tm_ms) % UINT32
        repeats, runs_back = not 0 < n_steps <= UINT32 // 2, passed_ms > UINT32 // 2
        later = 0 < passed_ms < UINT32 // 2
        # What was believed before a silence may have been wrong: it refuses nothing for ever.
        if ((repeats or runs_back) and silent) or (repeats and feedback.seqno == 0 and later):
            return Judgement(Verdict.NEW_SESSION, 'session_restarted')
        if repeats:
            code = 'duplicate' if n_steps == 0 else 'out_of_order'
            return self._refuse(Verdict.IGNORE, code)
        if runs_back:
            return self._refuse(Verdict.IGNORE, 'time_runs_back')
        return Judgement(Verdict.ACCEPT, n_steps=n_steps)

    def _doubt(self, feedback: RobotFeedback, judgement: Judgement, now_s: float) -> str:
        """Return what a packet alone is not believed; empty when nothing is."""
        last = self._last
        if last is None:
            return ''
        passed_s = now_s - self._heard_s
        begins = judgement.verdict == Verdict.NEW_SESSION
        if not begins and self._is_ahead(feedback, last, passed_s):
            return 'ahead'
        reach_s = passed_s + self.limits.cycle_s if begins else self._between_s(last, feedback)
        if self._jumps(feedback.joints_deg, last.joints_deg, reach_s):
            return 'joint_jump'
        jumps = self._jumps(feedback.planned_deg, last.planned_deg, reach_s)
        return 'planned_jump' if jumps else ''

    def _is_ahead(self, feedback: RobotFeedback, last: RobotFeedback, passed_s: float) -> bool:
        """Tell whether number or clock ran on without the time for it, or without the other."""
        longest_s = passed_s + self.limits.silence_s
        counted_s = self._between_s(last, feedback)
        clock_s = (feedback.tm_ms - last.tm_ms) % UINT32 / MILLISECONDS
        if max(counted_s, clock_s) > longest_s:
            return True
        # Half: whether the period is the expected one is asked at the start.
        return counted_s > FEW_CYCLES * self.limits.cycle_s and 0.0 < clock_s < 0.5 * counted_s

    def _goes_on(self, feedback: RobotFeedback) -> bool:
        """Tell whether a packet is the next after the one that was set aside."""
        doubted = self._doubted
        if doubted is None:
            return False
        n_steps = (feedback.seqno - doubted.seqno) % UINT32
        clock_s = (feedback.tm_ms - doubted.tm_ms) % UINT32 / MILLISECONDS
        if not (0 < n_steps <= FEW_CYCLES and clock_s <= self.limits.silence_s):
            return False
        reach_s = self._between_s(doubted, feedback)
        return not (
            self._jumps(feedback.joints_deg, doubted.joints_deg, reach_s)
            or self._jumps(feedback.planned_deg, doubted.planned_deg, reach_s)
        )

    def _between_s(self, before: RobotFeedback, feedback: RobotFeedback) -> float:
        """Return the time an axis had to move between two packets [s]."""
        return (feedback.seqno - before.seqno) % UINT32 * self.limits.cycle_s

    def _jumps(self, now_deg: Joints, before_deg: Joints, reach_s: float) -> bool:
        slack_deg = self.limits.jump_slack_deg
        return any(
            abs(now - before) > speed * reach_s + slack_deg
            for now, before, speed in zip(
                now_deg, before_deg, self.limits.max_speed_deg_s, strict=True
            )
        )

    def _refuse(self, verdict: Verdict, reason: str) -> Judgement:
        self.counts[reason] += 1
        self.counts['rejected'] += 1
        return Judgement(verdict, reason)
