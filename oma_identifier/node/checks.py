"""What is found wrong, by check: every check keeps its name, also while it is healthy."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

OK, WARN, ERROR, STALE = range(4)
"""Levels of diagnostic_msgs/DiagnosticStatus."""
SAMPLES, CHANNELS, WINDOWS, NODE = 'samples', 'channels', 'windows', 'node'
CHECKS = (SAMPLES, CHANNELS, WINDOWS, NODE)
LEVELS = {'WINDOW_FAILED': ERROR, 'NAME_CLASH': ERROR, 'NO_DATA': STALE}
HEALTHY = 'OK'


@dataclass(frozen=True, slots=True)
class Check:
    """One check and what it found.

    Parameters
    ----------
    name : str
        One of ``CHECKS``.
    level : int
        The worst.
    message : str
        Code and text of the worst, and how many more there are; ``OK`` for none.
    findings : tuple of (code, text)
        All.
    """

    name: str
    level: int
    message: str
    findings: tuple[tuple[str, str], ...]


Findings = Sequence[tuple[str, str]]
"""Code and text of each."""


def checks(found: Mapping[str, Findings]) -> tuple[Check, ...]:
    """Return all checks of what was found by each; those that found nothing are healthy."""
    return tuple(_check(name, found.get(name, ())) for name in CHECKS)


def _check(name: str, findings: Findings) -> Check:
    if not findings:
        return Check(name, OK, HEALTHY, ())
    levels = [LEVELS.get(code, WARN) for code, _ in findings]
    # What is stale says that nothing is known: an error beside it is worse all the same.
    worst = max(levels, key=(OK, STALE, WARN, ERROR).index)
    code, text = findings[levels.index(worst)]
    more = f' (and {len(findings) - 1} more)' if len(findings) > 1 else ''
    return Check(name, worst, f'{code} {text}{more}', tuple(findings))
