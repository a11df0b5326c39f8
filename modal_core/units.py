"""Units of responses and times: what each measures, and its factor to the SI unit."""

from dataclasses import dataclass
import math
import re

from modal_core.errors import ModalAnalysisError

STANDARD_GRAVITY = 9.80665
ACCELERATION = 'm/s^2'
VELOCITY = 'm/s'
DISPLACEMENT = 'm'
ANGULAR_ACCELERATION = 'rad/s^2'
ANGULAR_VELOCITY = 'rad/s'
STRAIN = 'm/m'
SECOND, OTHER = 's', ''
TIMES_DERIVED = {
    ACCELERATION: 2,
    VELOCITY: 1,
    DISPLACEMENT: 0,
    ANGULAR_ACCELERATION: 2,
    ANGULAR_VELOCITY: 1,
    STRAIN: 0,
}
"""How often what a channel measures was differentiated, by SI unit: of a mode with the pole s, its
entries are those of the displacement, rotation or strain times s to that power."""
KINDS = {
    ACCELERATION: 'acceleration',
    VELOCITY: 'velocity',
    DISPLACEMENT: 'displacement',
    ANGULAR_ACCELERATION: 'angular acceleration',
    ANGULAR_VELOCITY: 'angular velocity',
    STRAIN: 'strain',
}
DEGREE = math.pi / 180.0
FACTORS = {
    ACCELERATION: {
        'm/s^2': 1.0, 'mm/s^2': 1e-3, 'cm/s^2': 1e-2, 'gal': 1e-2, 'g': STANDARD_GRAVITY,
        'mg': 1e-3 * STANDARD_GRAVITY, 'ug': 1e-6 * STANDARD_GRAVITY, 'ft/s^2': 0.3048,
        'in/s^2': 0.0254,
    },
    VELOCITY: {'m/s': 1.0, 'mm/s': 1e-3, 'cm/s': 1e-2, 'um/s': 1e-6, 'in/s': 0.0254},
    DISPLACEMENT: {'m': 1.0, 'mm': 1e-3, 'um': 1e-6, 'cm': 1e-2, 'in': 0.0254, 'mil': 2.54e-5},
    ANGULAR_ACCELERATION: {'rad/s^2': 1.0, 'deg/s^2': DEGREE},
    ANGULAR_VELOCITY: {'rad/s': 1.0, 'mrad/s': 1e-3, 'deg/s': DEGREE, 'mdps': 1e-3 * DEGREE},
    STRAIN: {'m/m': 1.0, 'mm/m': 1e-3, 'um/m': 1e-6},
    SECOND: {'s': 1.0, 'ms': 1e-3, 'us': 1e-6, 'ns': 1e-9, 'min': 60.0, 'h': 3600.0},
}  # fmt: skip
RESPONSES = tuple(text for si in TIMES_DERIVED for text in FACTORS[si])
TIME_SPELLINGS = {
    's': 'sec secs second seconds sek sekunde sekunden seg segundos secondes',
    'ms': 'msec msecs millis millisec milliseconds millisecond millisekunden',
    'us': 'usec usecs micros microseconds microsecond mikrosekunden',
    'ns': 'nsec nsecs nanos nanosec nanoseconds nanosecond',
    'min': 'mins minute minutes minuten',
    'h': 'hr hrs hour hours stunden',
}
NEITHER = frozenset(
    """grad/s rpm 1/min hz khz 1/s km/h v mv uv a ma n kn mn dan lbf kgf gf nm n*m bar
    mbar pa kpa mpa hpa °c c degc k °f f degf % deg ° rad mrad t mt ut nt gauss mgauss
    count counts lsb adc raw bit bits digit digits db w ohm mv/v mv/g lux""".split()
)
"""Units of neither responses nor times; angles are those of joints."""
SPELLINGS = {
    **{word: unit for unit, words in TIME_SPELLINGS.items() for word in words.split()},
    **dict.fromkeys(('ms^-2', 'ms-2', 'm s^-2', 'm s-2', 'm/s/s', 'm/sec^2', 'mps2'), 'm/s^2'),
    **dict.fromkeys(('m*s^-2', 'ms^2', 'm/(s^2)', 'm/s²'), 'm/s^2'),
    **dict.fromkeys(('ips', 'in/sec'), 'in/s'),
    **dict.fromkeys(('dps', '°/s', 'deg/sec'), 'deg/s'),
    **dict.fromkeys(('°/s^2', 'deg/sec^2'), 'deg/s^2'),
    **dict.fromkeys(('ustrain', 'microstrain', 'ue', 'uε', 'uepsilon'), 'um/m'),
    'strain': 'm/m',
    **dict.fromkeys(('gn', 'g0', 'g_n', 'gs'), 'g'),
}
SIGNS = str.maketrans({'²': '^2', '−': '-', '⁻': '-', 'µ': 'u', 'μ': 'u', '·': '*', '⋅': '*'})
MANY = re.compile(r'^\s*(\d[\d.]*(?:[eE][+-]?\d+)?)\s+(\S.*)$')
WITH_UNIT = re.compile(r'^(.*\S)\s*\[([^\[\]]+)\]$')


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit and what it measures.

    Parameters
    ----------
    si : str
        The SI unit of the same quantity; empty of what is neither a response nor a time.
    factor : float
        To the SI unit.
    """

    si: str
    factor: float = 1.0

    @property
    def is_response(self) -> bool:
        """Whether channels are measured in it."""
        return self.si in TIMES_DERIVED


def known_unit(text: str) -> Unit | None:
    """Return the unit a text spells; None when it spells none that is known."""
    word = ' '.join(text.strip().lower().translate(SIGNS).replace('**', '^').split())
    word = SPELLINGS.get(word, word)
    if '/' in word and word.endswith('s2'):
        word = word[:-1] + '^2'
    for si, factors in FACTORS.items():
        if word in factors:
            return Unit(si, factors[word])
    return Unit(OTHER) if word in NEITHER else None


def response_unit(text: str, where: object, error: type[ModalAnalysisError]) -> Unit:
    """Return a unit of channels, which may be so many of another: ``50 m/s^2``.

    Raises
    ------
    ModalAnalysisError
        Of the class given: an unknown unit, naming those that are known.
    """
    many = MANY.match(text)
    found = known_unit(many.group(2) if many else text)
    factor = float(many.group(1)) if many else 1.0
    if found is None or not found.is_response or not 0.0 < factor < math.inf:
        raise error('unknown unit', where=where, found=text, expected=', '.join(RESPONSES))
    return Unit(found.si, factor * found.factor)


def named_unit(name: str) -> tuple[str, Unit | None]:
    """Return the name of a channel without the unit in square brackets that may end it.

    Brackets with anything else in them are part of the name.
    """
    found = WITH_UNIT.match(name)
    unit = known_unit(found.group(2)) if found else None
    return (found.group(1), unit) if found and unit and unit.is_response else (name, None)


def derived(unit: str, times: int) -> str:
    """Return the SI unit of a time derivative of what a channel measures."""
    base = unit.removesuffix('/s^2').removesuffix('/s')
    return base + ('', '/s', '/s^2')[TIMES_DERIVED[unit] + times]
