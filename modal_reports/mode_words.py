"""Marks of modes in tables: what calls for a second look, how a mode was estimated."""

import math

from modal_core.mode import Mode, SCATTERED_MPD_RAD

HARMONIC, SCATTERED, KNOWN = 'harmonic', 'phases scatter', 'known motion'
SCATTERED_MEANS = (
    f'MPD above {math.degrees(SCATTERED_MPD_RAD):.0f}°. Two modes close together, a sensor with a'
    ' late clock, a pose that changed, or little signal'
)


def mark(mode: Mode) -> str:
    """Return the marks of a mode; empty for most."""
    if mode.harmonic:
        return HARMONIC
    marks = {SCATTERED: mode.phases_scatter, KNOWN: mode.known_motion}
    return ', '.join(word for word, holds in marks.items() if holds)
