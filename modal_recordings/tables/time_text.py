"""Dates and times of day as text, as data loggers write them, in seconds."""

from collections.abc import Sequence
from datetime import datetime, timedelta, UTC
import re

CLOCK = r'(\d{1,2}):(\d{2})(?::(\d{2}))?(?:[.,](\d{1,12}))?\s*([AaPp][Mm])?'
DATE_TIME = re.compile(rf'^(?:(\d{{1,4}})[-/.](\d{{1,2}})[-/.](\d{{1,4}})[T\s]\s*)?{CLOCK}'
                       r'\s*(Z|UTC|[+-]\d{2}:?\d{2})?$')  # fmt: skip
DATE = re.compile(r'^(\d{1,4})[-/.](\d{1,2})[-/.](\d{1,4})$')
DAY_S, HOUR_S = 86400.0, 3600.0


def is_time_text(cell: str) -> bool:
    """Tell whether a cell is a date, a time of day, or both."""
    return (':' in cell and DATE_TIME.match(cell) is not None) or DATE.match(cell) is not None


def seconds_of(cell: str) -> float:
    """Return a date or time in seconds: since 1970 with a date, else since midnight.

    ``MM:SS.f`` counts from the full hour, as spreadsheets write it.

    Raises
    ------
    ValueError
        It is none, or its day and month could be either.
    """
    cell = cell.strip().strip('"')
    found = DATE_TIME.match(cell)
    if found is None:
        date = DATE.match(cell)
        if date is None:
            raise ValueError('not a date or time')
        return _midnight_s(date.groups(), dotted='.' in cell)
    dotted = '.' in cell.split(':')[0]
    *date_parts, hour, minute, second, fraction, half, zone = found.groups()
    part_s = float(f'0.{fraction}') if fraction else 0.0
    if second is None and fraction is not None:
        hour, minute, second = '0', hour, minute
    hours = int(hour)
    if half:
        hours = hours % 12 + (12 if half.lower() == 'pm' else 0)
    if hours > 24 or int(minute) > 59 or int(second or 0) > 60:
        raise ValueError('not a time of day')
    day_s = hours * HOUR_S + int(minute) * 60.0 + int(second or 0) + part_s
    return (
        day_s
        + (_midnight_s(date_parts, dotted=dotted) if date_parts[0] else 0.0)
        - _offset_s(zone)
    )


def _midnight_s(parts: Sequence[str], dotted: bool) -> float:
    first, second, third = parts
    one, two, three = int(first), int(second), int(third)
    if len(first) == 4:
        year, month, day = one, two, three
    elif one > 12 or dotted:
        day, month, year = one, two, three
    elif two > 12:
        month, day, year = one, two, three
    elif one == two:
        day, month, year = one, two, three
    else:
        raise ValueError('day and month could be either')
    since = datetime(year + (2000 if year < 100 else 0), month, day, tzinfo=UTC)
    return (since - datetime(1970, 1, 1, tzinfo=UTC)) / timedelta(seconds=1)


def _offset_s(zone: str | None) -> float:
    if zone is None or zone in ('Z', 'UTC'):
        return 0.0
    sign = -1.0 if zone[0] == '-' else 1.0
    return sign * (int(zone[1:3]) * HOUR_S + int(zone[-2:]) * 60.0)
