"""Which packets belong to the session: one peer, rising numbers, no jumps."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from robot_bridge.egm_feedback import RobotFeedback

Address = tuple[str, int]
UINT32 = 1 << 32


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
        After this long without a packet a session that starts again is believed.
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
        if judgement.verdict in (Verdict.ACCEPT, Verdict.NEW_SESSION):
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
        if n_steps == 0 or n_steps > UINT32 // 2:
            later = 0 < (feedback.tm_ms - last.tm_ms) % UINT32 < UINT32 // 2
            if silent or (feedback.seqno == 0 and later):
                return Judgement(Verdict.NEW_SESSION, 'session_restarted')
            code = 'duplicate' if n_steps == 0 else 'out_of_order'
            return self._refuse(Verdict.IGNORE, code)
        if (feedback.tm_ms - last.tm_ms) % UINT32 > UINT32 // 2:
            return self._refuse(Verdict.IGNORE, 'time_runs_back')
        reach = n_steps * self.limits.cycle_s
        for axis, speed in enumerate(self.limits.max_speed_deg_s):
            step = abs(feedback.joints_deg[axis] - last.joints_deg[axis])
            if step > speed * reach + self.limits.jump_slack_deg:
                # Remembered all the same: the axis may really be there now.
                self._last, self._heard_s = feedback, now_s
                return self._refuse(Verdict.ALARM, 'joint_jump')
        return Judgement(Verdict.ACCEPT, n_steps=n_steps)

    def _refuse(self, verdict: Verdict, reason: str) -> Judgement:
        self.counts[reason] += 1
        self.counts['rejected'] += 1
        return Judgement(verdict, reason)
