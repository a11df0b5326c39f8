"""Units that array files come in: of acceleration, of time, and of what is neither."""

from dataclasses import dataclass

from modal_core.errors import RecordingError

STANDARD_GRAVITY = 9.80665
UNITS = {
    'm/s^2': 1.0,
    'mm/s^2': 1e-3,
    'cm/s^2': 1e-2,
    'gal': 1e-2,
    'g': STANDARD_GRAVITY,
    'mg': 1e-3 * STANDARD_GRAVITY,
    'ug': 1e-6 * STANDARD_GRAVITY,
    'ft/s^2': 0.3048,
    'in/s^2': 0.0254,
}
TIME_UNITS = {'s': 1.0, 'ms': 1e-3, 'us': 1e-6, 'ns': 1e-9, 'min': 60.0, 'h': 3600.0}
TIME_SPELLINGS = {
    's': 'sec secs second seconds sek sekunde sekunden seg segundos secondes',
    'ms': 'msec msecs millis millisec milliseconds millisecond millisekunden',
    'us': 'usec usecs micros microseconds microsecond mikrosekunden',
    'ns': 'nsec nsecs nanos nanosec nanoseconds nanosecond',
    'min': 'mins minute minutes minuten',
    'h': 'hr hrs hour hours stunden',
}
NEITHER = frozenset(
    """rad/s deg/s °/s dps grad/s mrad/s mdps rpm 1/min hz khz 1/s rad/s^2 deg/s^2 °/s^2 m/s
    mm/s cm/s km/h in/s ips m mm um cm in mil v mv uv a ma n kn nm n*m bar mbar pa kpa mpa
    hpa °c c degc k °f f degf % deg ° rad mrad t mt ut nt gauss mgauss count counts lsb adc
    raw bit bits digit digits db um/m ustrain strain ue w ohm mv/v mv/g lux""".split()
)
"""Units that are neither of acceleration nor of time."""
SPELLINGS = {
    **{word: unit for unit, words in TIME_SPELLINGS.items() for word in words.split()},
    **dict.fromkeys(('ms^-2', 'ms-2', 'm s^-2', 'm s-2', 'm/s/s', 'm/sec^2', 'mps2'), 'm/s^2'),
    **dict.fromkeys(('m*s^-2', 'ms^2', 'm/(s^2)', 'm/s²'), 'm/s^2'),
    **dict.fromkeys(('gn', 'g0', 'g_n', 'gs'), 'g'),
}
SIGNS = str.maketrans({'²': '^2', '−': '-', '⁻': '-', 'µ': 'u', 'μ': 'u', '·': '*', '⋅': '*'})


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit and what it measures.

    Parameters
    ----------
    kind : str
        ``acceleration``, ``time`` or ``neither``.
    factor : float
        To m/s² or s; 1 for what is neither.
    """

    kind: str
    factor: float = 1.0


def known_unit(text: str) -> Unit | None:
    """Return the unit a text spells; None when it spells none that is known."""
    word = ' '.join(text.strip().lower().translate(SIGNS).replace('**', '^').split())
    word = SPELLINGS.get(word, word)
    if '/' in word and word.endswith('s2'):
        word = word[:-1] + '^2'
    if word in UNITS:
        return Unit('acceleration', UNITS[word])
    if word in TIME_UNITS:
        return Unit('time', TIME_UNITS[word])
    return Unit('neither') if word in NEITHER else None


def to_si(unit: str, where: object = '') -> float:
    """Return the factor from a unit of acceleration to m/s².

    Raises
    ------
    RecordingError
        Unknown unit, naming those that are known.
    """
    found = known_unit(unit)
    if found is None or found.kind != 'acceleration':
        raise RecordingError('unknown unit', where=where, found=unit, expected=', '.join(UNITS))
    return found.factor
