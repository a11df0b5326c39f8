"""Numbers as an engineer writes them: as many digits as the standard deviation supports.

``None`` and what is not finite is not known.
"""

import math
import sys
from typing import TypeAlias

Number: TypeAlias = float | None
UNKNOWN = '\N{EN DASH}'
MOST_DECIMALS = 6
# Beyond these a power of ten is written apart.
READABLE = (1e-3, 1e6)


def with_sigma(value: Number, std: Number = None, unit: str = '') -> str:
    """Return a value with its standard deviation and unit: ``3.420 ± 0.018 Hz``.

    Parameters
    ----------
    value, std : float or None
        In the unit; a deviation that is not known is left out.
    unit : str
        Behind both; none for ``''`` and ``'1'``.
    """
    exponent = _exponent(value, std)
    text = _scaled(value, std, exponent)
    if text != UNKNOWN and _known(std) and std:
        text += f' ± {_scaled_deviation(value, std, exponent)}'
        text = f'({text})' if exponent else text
    if text == UNKNOWN:
        return UNKNOWN
    return f'{text}{f"e{exponent}" if exponent else ""}{"" if unit in ("", "1") else f" {unit}"}'


def value_text(value: Number, std: Number = None) -> str:
    """Return a value rounded to the digits its deviation supports, or to four."""
    exponent = _exponent(value, std)
    text = _scaled(value, std, exponent)
    return f'{text}e{exponent}' if exponent and text != UNKNOWN else text


def deviation_text(value: Number, std: Number) -> str:
    """Return a standard deviation with the decimals of its value."""
    exponent = _exponent(value, std)
    text = _scaled_deviation(value, std, exponent)
    return f'{text}e{exponent}' if exponent and text != UNKNOWN else text


def fixed(value: Number, decimals: int, *, sign: bool = False) -> str:
    """Return a value with a fixed number of decimals."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    # Adding zero turns a rounded minus zero into plain zero.
    rounded = round(value, decimals) + 0.0
    return _minus(f'{rounded:{"+" if sign and rounded else ""}.{decimals}f}')


def significant(value: Number, digits: int = 3) -> str:
    """Return a value with so many significant digits, without an exponent where it is readable."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    if value == 0.0:
        return '0'
    if 1e-4 <= abs(value) < 1e6:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        return _minus(f'{value:.{decimals}f}')
    return _minus(f'{value:.{digits - 1}e}')


def percent(fraction: Number, decimals: int = 1, *, sign: bool = False) -> str:
    """Return a fraction as per cent: ``2.0 %``."""
    if fraction is None or not math.isfinite(fraction):
        return UNKNOWN
    return f'{fixed(100.0 * fraction, decimals, sign=sign)} %'


def _known(number: Number) -> bool:
    return number is not None and math.isfinite(number) and number >= 0.0


def _exponent(value: Number, std: Number) -> int:
    """Return the power of ten to write apart, 0 for none."""
    numbers = [abs(n) for n in (value, std) if n is not None and math.isfinite(n)]
    largest = max(numbers, default=0.0)
    if largest < sys.float_info.min or READABLE[0] <= largest < READABLE[1]:
        return 0
    return math.floor(math.log10(largest))


def _decimals(value: float, std: Number) -> int:
    """Return how many decimals show two digits of the deviation, or four of the value."""
    if _known(std) and std:
        wanted = 1 - math.floor(math.log10(std))
    elif math.isfinite(value) and value != 0.0:
        wanted = 3 - math.floor(math.log10(abs(value)))
    else:
        wanted = 2
    return min(max(wanted, 0), MOST_DECIMALS)


def _scaled(value: Number, std: Number, exponent: int) -> str:
    if value is None or not math.isfinite(value):
        return UNKNOWN
    scale = 10.0**-exponent
    return fixed(value * scale, _decimals(value * scale, _times(std, scale)))


def _scaled_deviation(value: Number, std: Number, exponent: int) -> str:
    if std is None or not _known(std):
        return UNKNOWN
    scale = 10.0**-exponent
    decimals = _decimals(_times(value, scale) or 0.0, std * scale)
    rounded = f'{std * scale:.{decimals}f}'
    # A deviation below the last decimal is not none.
    return rounded if float(rounded) or not std else f'{std * scale:.1e}'


def _times(number: Number, scale: float) -> Number:
    return None if number is None else number * scale


def _minus(text: str) -> str:
    return text.replace('-', '\N{MINUS SIGN}') if 'e' not in text else text
