"""The methods by name: the same samples in, the same pole table and mode set out.

All keep to the band asked for and keep the lines of machines out.  What tells their uncertainty
differs: ``ssi_cov`` has the adjoint of its own poles, ``ssi_data``, ``plscf`` and ``csi`` the
jackknife of blocks, ``efdd`` the information of its likelihood.  ``fdd`` reads a peak off a
spectrum: it has no damping and no deviation, both are NaN.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import SettingsError
from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleTable
from modal_core.samples import Samples
from oma_identifier.covariance import plan_bands
from oma_identifier.identify import check_samples, harmonic, identify_samples, no_poles
from oma_identifier.methods.banded import banded, by_csi, by_plscf, by_ssi_data, Solver
from oma_identifier.methods.fdd import efdd, fdd
from oma_identifier.motion import never, PeakTest
from oma_identifier.one_thread import one_thread
from oma_identifier.settings import IdentificationSettings, METHODS
from oma_identifier.spectra import CHANCE, line_at, LineEvidence, SUSPECT_DAMPING

SOLVERS: dict[str, Solver] = {'ssi_data': by_ssi_data, 'plscf': by_plscf, 'csi': by_csi}
SPECTRAL: dict[str, Callable[..., ModeSet]] = {'fdd': fdd, 'efdd': efdd}
FEWEST_POLES = 3
SHARP = 2.0 * SUSPECT_DAMPING
"""Peaks damped less may be lines; the image of a line has next to no damping."""


@dataclass(frozen=True, slots=True)
class MethodResult:
    """What a method found.

    Parameters
    ----------
    modes, harmonics : ModeSet
        Of the structure, and lines of machines and drives; by frequency.
    poles : PoleTable
        All poles with the reason each was kept or rejected; empty for FDD and EFDD.
    """

    modes: ModeSet
    harmonics: ModeSet
    poles: PoleTable


def identify_by(
    method: str,
    samples: Samples,
    settings: IdentificationSettings | None = None,
    inputs: NDArray[np.float64] | None = None,
    explains: PeakTest = never,
) -> MethodResult:
    """Identify the modes of one stretch of samples by the named method.

    Parameters
    ----------
    method : str
        One of :data:`METHODS`.
    samples : Samples
        Responses.
    settings : IdentificationSettings or None
        None: the defaults.
    inputs : (n_samples, n_inputs) array or None
        Known inputs on the grid of the samples; ``csi`` needs them, the others do without.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.

    Raises
    ------
    SettingsError
        Unknown method, or ``csi`` without inputs.
    IdentificationError
        The samples cannot be identified.
    """
    settings = settings or IdentificationSettings()
    if method not in METHODS:
        raise SettingsError(
            'unknown method', where='method', found=method, expected=', '.join(METHODS)
        )
    if method == 'csi' and inputs is None:
        raise SettingsError('csi needs the known inputs', where='inputs')
    check_samples(samples)
    with one_thread():
        if method == 'ssi_cov':
            result = identify_samples(samples, settings)
            return MethodResult(result.modes, result.harmonics, result.poles)
        if method in SOLVERS:
            known = inputs if method == 'csi' else None
            modes, poles = banded(method, samples, settings, SOLVERS[method], known)
        else:
            bands = plan_bands(samples.sample_rate_hz, samples.duration_s, settings)
            band_hz = bands[-1].low_hz, bands[0].high_hz
            modes = SPECTRAL[method](samples, band_hz=band_hz)
            poles = no_poles(len(samples.channels))
            suspects = fdd(samples, band_hz=band_hz).frequency_hz
        if method in SOLVERS:
            suspects = _undamped(poles)
        lines = _lines(samples, modes, suspects)
        evidence = LineEvidence.of(samples, [line.frequency_hz for line in lines], modes)
        return _without_lines(modes, poles, lines, explains, evidence)


def _undamped(poles: PoleTable) -> NDArray[np.float64]:
    """Return the frequencies where poles with next to no damping repeat over the orders [Hz]."""
    bare = np.sort(poles.frequency_hz[np.abs(poles.damping_ratio) < SUSPECT_DAMPING])
    runs = np.split(bare, np.flatnonzero(np.diff(bare) > SUSPECT_DAMPING * bare[:-1]) + 1)
    return np.array([np.median(run) for run in runs if len(run) >= FEWEST_POLES])


def _lines(samples: Samples, modes: ModeSet, suspects_hz: NDArray[np.float64]) -> tuple[Mode, ...]:
    sharp = [mode.frequency_hz for mode in modes if not mode.damping_ratio > SHARP]
    lines: list[Mode] = []
    for suspect_hz in sorted((*sharp, *suspects_hz)):
        line = line_at(samples, suspect_hz)
        known = lines and abs(lines[-1].frequency_hz / line.frequency_hz - 1.0) < SUSPECT_DAMPING
        if line.chance < CHANCE and not known:
            lines.append(harmonic(line))
    return tuple(lines)


def _without_lines(
    modes: ModeSet,
    poles: PoleTable,
    lines: tuple[Mode, ...],
    explains: PeakTest,
    evidence: LineEvidence,
) -> MethodResult:
    """Sort out what is no mode of the structure, and number the poles' modes anew."""
    spectral = modes.method in SPECTRAL
    kept: list[Mode] = []
    rank = np.zeros(len(modes) + 1, dtype=np.int64)
    for number, mode in enumerate(modes, start=1):
        # NaN, where a method knows no damping, may be a line.
        is_line = not mode.damping_ratio > SHARP and any(
            abs(line.frequency_hz / mode.frequency_hz - 1.0) < SHARP for line in lines
        )
        is_line |= evidence.explains(mode, anywhere=spectral)
        width_hz = mode.frequency_hz * np.nan_to_num(mode.damping_ratio)
        if not is_line and not explains(mode.frequency_hz, width_hz, mode.shape):
            kept.append(mode)
            rank[number] = len(kept)
    numbered = replace(poles, mode_id=rank[poles.mode_id])
    return MethodResult(replace(modes, modes=tuple(kept)), replace(modes, modes=lines), numbered)
