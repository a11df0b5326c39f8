"""What a tap test found."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses import PointData
from impact_testing.taps import JudgedTap
from modal_core.mode import Mode, ModeSet

Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class ScaledMode:
    """A mode with its mass.

    Parameters
    ----------
    mode : Mode
        Frequency, damping and shape with their standard deviations.
    modal_mass_kg, modal_mass_std_kg : float [kg]
        Of the shape whose largest entry is 1; NaN where no driving point was measured.
    """

    mode: Mode
    modal_mass_kg: float
    modal_mass_std_kg: float

    def mass_normalised(self) -> Complex:
        """Return the shape of unit modal mass [1/√kg]."""
        return np.asarray(self.mode.shape / np.sqrt(self.modal_mass_kg))


@dataclass(frozen=True)
class TestedPoint:
    """One point that was hit.

    Parameters
    ----------
    name : str
        Of the recording.
    hit : str
        The point and its direction; empty: not known.
    taps : tuple of JudgedTap
        All of them.
    data : PointData
        FRFs of the good ones, coherence, noise.
    synthesised : (n_lines, n_channels) complex array [m/s²/N]
        What the modes give, in the band.
    """

    name: str
    hit: str
    taps: tuple[JudgedTap, ...]
    data: PointData
    synthesised: Complex

    @property
    def measured(self) -> Complex:
        """FRFs in the band [m/s²/N], (n_lines, n_channels) array."""
        return np.asarray(self.data.frf.h1[self.data.lines])

    @property
    def agreement(self) -> NDArray[np.float64]:
        """FRAC of synthesised and measured FRFs, (n_channels,) array."""
        return frac(self.synthesised, self.measured)

    def told_taps(self) -> Iterator[tuple[str, int, float, JudgedTap]]:
        """Yield each tap with the name of its recording, its number and time [s] in there."""
        record, counts = self.data.frf.spectra.record, Counter[str]()
        for each in self.taps:
            run = record.run_of(each.tap.first)
            counts[run.name] += 1
            time_s = (each.tap.peak - run.first) / record.rate_hz
            yield run.name, counts[run.name], time_s, each

    @property
    def n_good(self) -> int:
        """Taps that take part."""
        return sum(each.good for each in self.taps)


@dataclass(frozen=True)
class ImpactResult:
    """Modes of a tap test and what speaks for them.

    Parameters
    ----------
    scaled_modes : tuple of ScaledMode
        By frequency.
    places : tuple of str
        Entries of the shapes: channels and points hit.
    points : tuple of TestedPoint
    band_hz : (2,) tuple [Hz]
        Where modes were looked for.
    length_s : float [s]
        Of the segments.
    misfit : float
        Mean square of what the modes leave over the noise; 1: the noise alone.
    driving_phase_deg : dict of str to tuple of float
        Per driving point, by mode: by how much its residue is out of phase with a mass.
    reciprocity : dict of str to float
        FRAC of two points hit that have channels, both ways.
    remarks : tuple of str
        What should be known of it.
    """

    scaled_modes: tuple[ScaledMode, ...]
    places: tuple[str, ...]
    points: tuple[TestedPoint, ...]
    band_hz: tuple[float, float]
    length_s: float
    misfit: float
    driving_phase_deg: dict[str, tuple[float, ...]]
    reciprocity: dict[str, float]
    remarks: tuple[str, ...] = ()

    @property
    def modes(self) -> ModeSet:
        """The modes without their masses."""
        return ModeSet(tuple(each.mode for each in self.scaled_modes), self.places, 'impact')


def frac(first: Complex, second: Complex) -> NDArray[np.float64]:
    """Return the frequency response assurance criterion of columns.

    References
    ----------
    Heylen and Lammens (1996), FRAC: a consistent way of comparing frequency response functions.
    """
    both = np.abs(np.sum(first.conj() * second, axis=0)) ** 2
    size = np.sum(np.abs(first) ** 2, axis=0) * np.sum(np.abs(second) ** 2, axis=0)
    return np.asarray(np.divide(both, size, out=np.zeros_like(both), where=size > 0.0))
