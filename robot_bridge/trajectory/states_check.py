"""Which joint states are believed: those of one publisher, in its order, without jumps.

The running number is the one that the middleware gives a publisher's messages, which keeps their
order: one that does not rise is of another publisher.  Their time is their stamp's.
"""

from dataclasses import replace

from robot_bridge.egm import (
    Address,
    Judgement,
    MICROSECONDS,
    RobotFeedback,
    SessionCheck,
    Verdict,
)


class StatesCheck(SessionCheck):
    """Judges joint states as packets are; on the way nothing repeats or reorders them."""

    def _compare(self, feedback: RobotFeedback, address: Address, now_s: float) -> Judgement:
        last = self._last
        judgement = super()._compare(feedback, address, now_s)
        if judgement.verdict == Verdict.IGNORE:
            return replace(judgement, verdict=Verdict.ALARM)
        if last is None or judgement.verdict != Verdict.ACCEPT:
            return judgement
        if feedback.time_us == last.time_us:
            # A simulation's clock stood still; what moved in no time is not judged.
            self.counts['old'] += 1
            return Judgement(Verdict.IGNORE, 'old')
        if feedback.time_us < last.time_us:  # by less than the millisecond of its clock
            return self._refuse(Verdict.ALARM, 'time_runs_back')
        return judgement

    def _between_s(self, before: RobotFeedback, feedback: RobotFeedback) -> float:
        return (feedback.time_us - before.time_us) / MICROSECONDS
