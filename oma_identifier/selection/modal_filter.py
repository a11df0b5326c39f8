"""The sum of channels that shows one response and not its neighbours, to test it for a line.

References
----------
Shelley and Allemang (1992), Calculation of discrete modal filters using the modified reciprocal
modal vector method, IMAC X.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.selection.identified_band import IdentifiedBand
from oma_identifier.selection.line_decision import LineTest
from oma_identifier.selection.selected_pole import SelectedPole
from oma_identifier.selection.thresholds import SELECTION
from oma_identifier.spectra import Line, SPECTRA


def modal_filter(
    shape: NDArray[np.complex128], neighbours: Sequence[NDArray[np.complex128]]
) -> NDArray[np.complex128]:
    """Return the weights of the channels that see a shape, and of its neighbours what they can.

    Parameters
    ----------
    shape : (n_channels,) complex array
        Of channels scaled to comparable noise.
    neighbours : sequence of (n_channels,) complex array
        The most disturbing first; half as many as there are channels count.
    """
    left, basis = shape, np.empty((len(shape), 0), dtype=complex)
    for other in neighbours[: len(shape) // 2]:
        other = other - basis @ (basis.conj().T @ other)
        more = np.column_stack([basis, other / max(float(np.linalg.norm(other)), 1e-300)])
        rest = shape - more @ (more.conj().T @ shape)
        if np.linalg.norm(rest) ** 2 > SELECTION.least_filtered * np.linalg.norm(shape) ** 2:
            left, basis = rest, more
    return np.asarray(left.conj())


@dataclass(frozen=True, slots=True)
class FilteredLineTest:
    """A test for lines that looks at a suspect by its own shape, and past its neighbours.

    Parameters
    ----------
    test_line : callable
        Frequency [Hz] and weights of the channels to the line there.
    poles : sequence of SelectedPole
        What may be a mode.
    bands : sequence of IdentifiedBand
        Where lines may be.
    """

    test_line: LineTest
    poles: Sequence[SelectedPole]
    bands: Sequence[IdentifiedBand]

    def line_at(self, frequency_hz: float) -> Line | None:
        """Return the line at a suspected frequency, None where nothing can be said."""
        band = next(
            (each for each in self.bands if each.band.low_hz < frequency_hz < each.band.high_hz),
            None,
        )
        shape = None if band is None else self._shape(frequency_hz, band)
        if band is None or shape is None or len(shape) < SELECTION.fewest_filtered:
            return self.test_line(frequency_hz, None)
        resolution_hz = 1.0 / band.duration_s
        others = [
            (abs(pole.frequency_hz - frequency_hz) / (resolution_hz + pole.half_width_hz), pole)
            for pole in self.poles
            if abs(pole.frequency_hz - frequency_hz) > resolution_hz
        ]
        inverse = np.divide(1.0, band.scale, out=np.zeros_like(band.scale), where=band.scale > 0.0)
        near = [pole.physical_shape * inverse for _, pole in sorted(others, key=lambda at: at[0])]
        return self.test_line(frequency_hz, modal_filter(shape, near) * inverse)

    def _shape(self, frequency_hz: float, band: IdentifiedBand) -> NDArray[np.complex128] | None:
        """Return the shape of the pole that is suspected, of scaled channels."""
        poles = band.poles
        away = np.abs(poles.frequency_hz / frequency_hz - 1.0)
        sharp = np.abs(poles.damping_ratio) < SPECTRA.suspect_damping
        for pole in self.poles:
            if pole.frequency_hz == frequency_hz:
                return pole.shape if pole.band is band else None
        if not sharp.any():
            return None
        return np.asarray(poles.shape[:, np.argmin(np.where(sharp, away, np.inf))])
