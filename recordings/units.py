"""Units of acceleration that array files come in."""

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
SPELLINGS = {'m/s2': 'm/s^2', 'm/s²': 'm/s^2', 'm/s**2': 'm/s^2', 'm s^-2': 'm/s^2', 'µg': 'ug'}


def to_si(unit: str, where: object = '') -> float:
    """Return the factor from a unit of acceleration to m/s².

    Raises
    ------
    RecordingError
        Unknown unit, naming those that are known.
    """
    word = unit.strip().lower().replace('²', '^2').replace('**', '^')
    if word.endswith('s2'):
        word = word[:-1] + '^2'
    word = SPELLINGS.get(word, word)
    if word not in UNITS:
        raise RecordingError('unknown unit', where=where, found=unit, expected=', '.join(UNITS))
    return UNITS[word]
