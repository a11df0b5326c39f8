"""Pictures of the modes beside each other; nothing where there is little to compare."""

from collections.abc import Sequence

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac_where_seen
from modal_reports import (
    complexity_plot,
    DAMPING,
    damping_plane,
    fixed,
    FREQUENCY,
    heat_map,
    HeatScale,
    PlacedMode,
)

MAC_SCALE = HeatScale(0.0, 1.0)
# More would not be read.
MOST_COMPARED = 16
NamedShapes = tuple[Sequence[str], NDArray[np.complex128]]


def mac_map(modes: ModeSet) -> Markup:
    """Return the map of MAC between the modes."""
    shown = _shown(modes)
    if not 2 <= len(shown) <= MOST_COMPARED or len(modes.channel_names) < 2:
        return Markup()
    shapes = ModeSet(shown, modes.channel_names).shapes
    names = [str(mode.id) if mode.id else fixed(mode.frequency_hz, 1) for mode in shown]
    return draw_mac('MAC between the modes', (names, shapes), (names, shapes))


def draw_mac(label: str, rows: NamedShapes, columns: NamedShapes) -> Markup:
    """Return the map of MAC of each shape with each other, over the same channels."""
    (names, first), (others, second) = rows, columns
    panels = [('', mac_where_seen(first, second))]
    return heat_map(label, names, others, panels, MAC_SCALE, '{:.2f}'.format)


def complexity(modes: ModeSet) -> Markup:
    """Return the mode shapes in the complex plane."""
    shown = _shown(modes)
    if not 1 <= len(shown) <= MOST_COMPARED or len(modes.channel_names) < 2:
        return Markup()
    panels = [(f'{fixed(mode.frequency_hz, 2)} Hz', np.asarray(mode.shape)) for mode in shown]
    return complexity_plot('Mode shapes in the complex plane', panels)


def damping_over_frequency(modes: ModeSet) -> Markup:
    """Return damping over natural frequency, with ellipses of ±2 σ."""
    shown = _shown(modes)
    return damping_plane('Damping over frequency', [*map(placed, shown)]) if shown else Markup()


def _shown(modes: ModeSet) -> tuple[Mode, ...]:
    return tuple(mode for mode in modes if not mode.harmonic)


def placed(mode: Mode) -> PlacedMode:
    """Return a mode in the plane of damping over frequency."""
    return PlacedMode(
        name=f'{FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz)} Hz,'
        f' {DAMPING.number(mode.damping_ratio, mode.damping_ratio_std)} %',
        frequency_hz=mode.frequency_hz,
        damping_percent=100.0 * mode.damping_ratio,
        frequency_std_hz=mode.frequency_std_hz,
        damping_std_percent=100.0 * mode.damping_ratio_std,
    )
