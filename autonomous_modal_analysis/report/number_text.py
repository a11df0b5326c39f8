"""Numbers as an engineer writes them: as many digits as the standard deviation supports."""

import math

UNKNOWN = '\N{EN DASH}'
MOST_DECIMALS = 6


def decimals_for(value: float, std: float) -> int:
    """Return how many decimals show two digits of the deviation, or four of the value."""
    if math.isfinite(std) and std > 0.0:
        wanted = 1 - math.floor(math.log10(std))
    elif math.isfinite(value) and value != 0.0:
        wanted = 3 - math.floor(math.log10(abs(value)))
    else:
        wanted = 2
    return min(max(wanted, 0), MOST_DECIMALS)


def value_text(value: float, std: float = math.nan) -> str:
    """Return a value rounded to the digits its deviation supports."""
    if not math.isfinite(value):
        return UNKNOWN
    return _minus(f'{value:.{decimals_for(value, std)}f}')


def deviation_text(value: float, std: float) -> str:
    """Return a standard deviation with the same decimals as its value."""
    if not (math.isfinite(std) and std >= 0.0):
        return UNKNOWN
    return f'{std:.{decimals_for(value, std)}f}'


def fixed(value: float, decimals: int, *, sign: bool = False) -> str:
    """Return a value with a fixed number of decimals."""
    if not math.isfinite(value):
        return UNKNOWN
    # Adding zero turns a rounded minus zero into plain zero.
    rounded = round(value, decimals) + 0.0
    return _minus(f'{rounded:{"+" if sign and rounded else ""}.{decimals}f}')


def significant(value: float, digits: int = 3) -> str:
    """Return a value with so many significant digits, without an exponent where it is readable."""
    if not math.isfinite(value):
        return UNKNOWN
    if value == 0.0:
        return '0'
    if 1e-4 <= abs(value) < 1e6:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        return _minus(f'{value:.{decimals}f}')
    return _minus(f'{value:.{digits - 1}e}')


def _minus(text: str) -> str:
    return text.replace('-', '\N{MINUS SIGN}') if 'e' not in text else text
