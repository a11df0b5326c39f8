"""The sample rate that lines above a table state."""

from collections.abc import Sequence
from pathlib import Path
import re

from modal_core.errors import RecordingError
from modal_core.units import known_unit, SECOND

VALUE = r'\W*([\d.,]+(?:[eE][-+]?\d+)?)\s*([^\s,;)\]]*)'
RATE = re.compile(
    r'(?:\b(?:sampl\w*|scan|data|acquisition)[\s_-]*(?:rate|freq\w*)|\babtast(?:rate|frequenz)'
    r'|\bf_?s\b|\bodr\b)(?:\s*[\[(]?(k?hz)[\])]?)?' + VALUE,
    re.IGNORECASE,
)
STEP = re.compile(
    r'(?:\b(?:sampl\w*|time)[\s_-]*(?:interval|period|increment|step)|\bdelta[_\s]?[tx]\b|\bdt\b)'
    r'(?:\s*[\[(]?([munµμ]?s)[\])]?)?' + VALUE,
    re.IGNORECASE,
)
PER_SECOND = {'hz': 1.0, 'khz': 1e3, 'sps': 1.0, 'ksps': 1e3, 's/s': 1.0, 'ks/s': 1e3, '': 1.0}


def stated_rate_hz(path: Path, lines: Sequence[str]) -> float | None:
    """Return the rate that remarks and other lines above a table state; None when none does.

    Raises
    ------
    RecordingError
        Two lines state different ones.
    """
    found = [rate for line in lines if (rate := _rate(line)) is not None]
    if found and max(found) > 1.001 * min(found):
        raise RecordingError(
            'two sample rates stated', where=path, found=f'{min(found):g} and {max(found):g} Hz'
        )
    return found[0] if found else None


def _rate(line: str) -> float | None:
    line = line[:1000]
    for pattern, inverse in ((RATE, False), (STEP, True)):
        match = pattern.search(line)
        number = _number(match.group(2)) if match else None
        if match is None or not number:
            continue
        word = (match.group(1) or match.group(3)).lower().strip('"[]()')
        if not inverse:
            return number * PER_SECOND[word] if word in PER_SECOND else None
        unit = known_unit(word or 's')
        return 1.0 / (number * unit.factor) if unit and unit.si == SECOND else None
    return None


def _number(text: str) -> float | None:
    try:
        return float(text.strip('.,').replace(',', '.'))
    except ValueError:
        return None
