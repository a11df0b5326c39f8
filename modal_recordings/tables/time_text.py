"""Dates and times of day as text, as data loggers write them, in seconds."""

from collections.abc import Sequence
from datetime import datetime, timedelta, UTC
import re

CLOCK = r'(\d{1,2}):(\d{2})(?::(\d{2}))?(?:[.,](\d{1,12}))?\s*([AaPp][Mm])?'
DATE_TIME = re.compile(rf'^(?:(\d{{1,4}})[-/.](\d{{1,2}})[-/.](\d{{1,4}})[T\s]\s*)?{CLOCK}'
                       r'\s*(Z|UTC|[+-]\d{2}:?\d{2})?$')  # fmt: skip
DATE = re.compile(r'^(\d{1,4})[-/.](\d{1,2})[-/.](\d{1,4})$')
DAY_S, HOUR_S = 86400.0, 3600.0
NUMERIC = re.compile(r'^(\d{1,4})([-/.])(\d{1,2})[-/.](\d{1,4})(?![\d])')

# Which of the three numbers of a date is its year, month and day.
DateOrder = tuple[int, int, int]
YEAR_FIRST, DAY_FIRST, MONTH_FIRST = (0, 1, 2), (2, 1, 0), (2, 0, 1)


def is_time_text(cell: str) -> bool:
    """Tell whether a cell is a date, a time of day, or both."""
    return (':' in cell and DATE_TIME.match(cell) is not None) or DATE.match(cell) is not None


def has_date(cell: str) -> bool:
    """Tell whether a date or time has a date."""
    return NUMERIC.match(cell) is not None


def date_order(cells: Sequence[str]) -> DateOrder | None:
    """Return in which order dates give year, month and day; None where it could be several.

    Of the orders in which all are dates, it is the one in which the dates lie closest.

    Parameters
    ----------
    cells : sequence of str
        Dates of one column, the first and the last of a recording among them.
    """
    dates = [(match[1], match[3], match[4]) for cell in cells if (match := NUMERIC.match(cell))]
    dotted = any('.' in cell[: cell.find(':')] for cell in cells)
    days: dict[DateOrder, list[float]] = {}
    for order in _orders(dates[0], dotted=dotted) if dates else ():
        try:
            days[order] = [_midnight_s(parts, order) for parts in dates]
        except ValueError:
            continue
    if not days:
        return None
    span_s = min(max(found) - min(found) for found in days.values())
    closest = [order for order, found in days.items() if max(found) - min(found) == span_s]
    return closest[0] if all(days[order] == days[closest[0]] for order in closest) else None


def _orders(parts: Sequence[str], *, dotted: bool) -> tuple[DateOrder, ...]:
    """Return the orders that a date of these numbers may have."""
    if len(parts[0]) == 4:
        return (YEAR_FIRST,)
    if dotted:
        return (DAY_FIRST,)
    two_digits = len(parts[2]) <= 2
    return (DAY_FIRST, MONTH_FIRST, YEAR_FIRST) if two_digits else (DAY_FIRST, MONTH_FIRST)


def seconds_of(cell: str, order: DateOrder | None) -> float:
    """Return a date or time in seconds: since 1970 with a date, else since midnight.

    ``MM:SS.f`` counts from the full hour, as spreadsheets write it.

    Parameters
    ----------
    cell : str
        As written.
    order : (3,) tuple of int or None
        Of the date; None: it is not used.

    Raises
    ------
    ValueError
        It is none.
    """
    cell = cell.strip().strip('"')
    found = DATE_TIME.match(cell)
    if found is None:
        date = DATE.match(cell)
        if date is None:
            raise ValueError('not a date or time')
        return 0.0 if order is None else _midnight_s(date.groups(), order)
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
    if date_parts[0] and order is not None:
        day_s += _midnight_s(date_parts, order)
    return day_s - _offset_s(zone)


def _midnight_s(parts: Sequence[str], order: DateOrder) -> float:
    year, month, day = (int(parts[place]) for place in order)
    since = datetime(year + (2000 if year < 100 else 0), month, day, tzinfo=UTC)
    return (since - datetime(1970, 1, 1, tzinfo=UTC)) / timedelta(seconds=1)


def _offset_s(zone: str | None) -> float:
    if zone is None or zone in ('Z', 'UTC'):
        return 0.0
    sign = -1.0 if zone[0] == '-' else 1.0
    return sign * (int(zone[1:3]) * HOUR_S + int(zone[-2:]) * 60.0)
