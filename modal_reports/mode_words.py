"""Marks of modes in tables that call for a second look, and what they mean."""

import math

from modal_core.mode import Mode, SCATTERED_MPD_RAD

HARMONIC, SCATTERED = 'harmonic', 'phases scatter'
SCATTERED_MEANS = (
    f'MPD above {math.degrees(SCATTERED_MPD_RAD):.0f}°. Two modes close together, a sensor with a'
    ' late clock, a pose that changed, or little signal'
)


def mark(mode: Mode) -> str:
    """Return the mark of a mode; empty for most."""
    if mode.harmonic:
        return HARMONIC
    return SCATTERED if mode.phases_scatter else ''
