"""Taps in, modes with their masses out: read it from top to bottom."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from impact_testing.checks import (
    driving_phases,
    reciprocity,
    remark_on_drift,
    remarks_on,
    remarks_on_chain,
    remarks_on_lines,
    remarks_on_peaks,
    remarks_on_sizes,
    remarks_on_taps,
    remarks_on_units,
)
from impact_testing.driving_sign import (
    all_against,
    driving_signs,
    DrivingSign,
    remarks_on_signs,
    turned,
    without_wrong_points,
)
from impact_testing.fit import (
    fitted,
    free_fit,
    ModalModel,
    refitted,
    synthesised,
)
from impact_testing.measuring_chain import (
    check_unwindowed,
    force_corner,
    MeasuringChain,
    restored,
    without_chain,
    without_drift,
)
from impact_testing.modes import scaled_modes, taps_differ, without_scale
from impact_testing.record import ImpactRecord, together
from impact_testing.responses import band_lines, PointData, PointFrf, PointSpectra
from impact_testing.result import ImpactResult, TestedPoint
from impact_testing.steady_lines import without_steady_lines
from impact_testing.taps import (
    Fault,
    FEWEST_TAPS,
    gaps,
    judge_taps,
    JudgedTap,
    points_of,
    usual_length,
    with_length,
)
from impact_testing.thresholds import IMPACT
from modal_core.errors import IdentificationError, SettingsError
from oma_identifier.one_thread import one_thread

HIGHEST_SHARE = 0.4
"""Of the sample rate: filters of converters begin to fall there."""
LEAST_DECAY = 0.05
"""Decay over a segment below which a mode is a line of something else, its damping unknown."""
FIRST_LINE = 2
"""Lowest line of the band: drift and offsets are below."""


@dataclass(frozen=True, slots=True)
class ImpactSettings:
    """What may be asked of a tap test; None: from the data.

    Parameters
    ----------
    min_frequency_hz, max_frequency_hz : float [Hz] or None
        Band in which modes are looked for; else up to where the force has lost 20 dB.
    segment_s : float [s] or None
        Of each tap that is used.
    window_end : float
        Exponential window on force and responses falls to this share; the damping it adds is
        taken out.  1: none, and none is needed.
    """

    min_frequency_hz: float | None = None
    max_frequency_hz: float | None = None
    segment_s: float | None = None
    window_end: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what is out of range.

        Raises
        ------
        SettingsError
            Naming it.
        """
        for name in ('min_frequency_hz', 'max_frequency_hz', 'segment_s'):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < 1e6:
                raise SettingsError('out of range', where=name, found=value, expected='> 0')
        if not 1e-6 <= self.window_end <= 1.0:
            raise SettingsError(
                'out of range', where='window_end', found=self.window_end, expected='1e-6 to 1'
            )


def impact_modes(
    records: Sequence[ImpactRecord], settings: ImpactSettings | None = None
) -> ImpactResult:
    """Identify the modes of a structure from taps.

    Parameters
    ----------
    records : sequence of ImpactRecord
        One per point hit (roving hammer) or set-up of sensors (roving accelerometers), or several
        of one point with the same sensors, as where each tap has a file.
    settings : ImpactSettings or None
        None: everything from the data.

    Raises
    ------
    IdentificationError
        No taps, fewer than two good ones on a point, rates that differ, responses that were
        windowed, or no mode.
    """
    settings = settings or ImpactSettings()
    _check_rates(records)
    without = [without_steady_lines(each) for each in records]
    points = points_of([each.record for each in without])
    cleared = [together([without[n].record for n in each]) for each in points]
    as_read = [together([records[n] for n in each]) for each in points]
    check_unwindowed(as_read)
    of_force = force_corner(cleared)
    if of_force.sure:
        cleared = [restored(each, of_force) for each in cleared]
    settled = [without_drift(each) for each in cleared]
    cleared, drift_n = [each for each, _ in settled], max(by_n for _, by_n in settled)
    judged, length_s = judged_together(cleared, settings.segment_s, as_read)
    decay = -np.log(settings.window_end) / length_s
    spectra = [
        _without_unlike(PointSpectra.of(record, taps, length_s, decay))
        for record, taps in zip(cleared, judged, strict=True)
    ]
    band_hz = analysed_band([PointFrf(each) for each in spectra], settings)
    lines = band_lines(spectra[0].frequency_hz, band_hz)
    try:
        with one_thread():
            data, chain = without_chain(spectra, lines, of_force)
            found = _identified(data, chain, band_hz, length_s)
    except np.linalg.LinAlgError as error:
        raise IdentificationError(
            'no sum of modes comes near the frequency responses',
            found=str(error),
            advice='check that force and responses belong together, or narrow the band',
        ) from error
    told = (
        *remarks_on_units(records),
        *remarks_on_sizes(records),
        *remarks_on_lines(without),
        *remark_on_drift(drift_n),
    )
    if any(each.without_unit for each in records):
        found = replace(found, scaled_modes=without_scale(found.scaled_modes))
    return replace(found, remarks=(*told, *found.remarks))


def _identified(
    data: Sequence[PointData],
    chain: MeasuringChain,
    band_hz: tuple[float, float],
    length_s: float,
) -> ImpactResult:
    fit, model = fitted(data)
    signs = driving_signs(fit, model, _reported(model, band_hz, length_s))
    if all_against(signs):
        fit = turned(fit)
        model = refitted(fit, replace(model, shape=1j * model.shape))
    model = without_wrong_points(fit, model, signs)
    return _result(fit, model, (chain, signs), band_hz, length_s)


def judged_together(
    records: Sequence[ImpactRecord],
    segment_s: float | None = None,
    as_read: Sequence[ImpactRecord] | None = None,
) -> tuple[list[tuple[JudgedTap, ...]], float]:
    """Judge the taps of all records, which have segments of one length.

    Parameters
    ----------
    records : sequence of ImpactRecord
        One for each point and its sensors.
    segment_s : float [s] or None
        None: as long as the taps allow.
    as_read : sequence of ImpactRecord or None
        The same before lines were taken out: what is clipped shows there.
    """
    judged = [
        judge_taps(record, read) for record, read in zip(records, as_read or records, strict=True)
    ]
    found = [
        gap
        for record, taps in zip(records, judged, strict=True)
        for each, gap in zip(taps, gaps(record, taps), strict=True)
        if each.good
    ]
    length_s = segment_s or usual_length(found)
    judged = [
        with_length(record, taps, length_s) for record, taps in zip(records, judged, strict=True)
    ]
    several = len(records) > 1
    for record, taps in zip(records, judged, strict=True):
        _check_taps(record, taps, several and not record.hit)
    return judged, length_s


def analysed_band(frfs: Sequence[PointFrf], settings: ImpactSettings) -> tuple[float, float]:
    """Return where modes are looked for: up to where the force has lost 20 dB."""
    spectra = frfs[0].spectra
    power = sum((f.force_power / f.force_power.max() for f in frfs), np.zeros(1))
    enough = power >= IMPACT.force_range * power.max()
    lost = int(np.argmin(enough)) if not enough.all() else len(power) - 1
    reach = min(float(spectra.frequency_hz[lost]), HIGHEST_SHARE * spectra.record.rate_hz)
    low = settings.min_frequency_hz or float(spectra.frequency_hz[FIRST_LINE - 1])
    high = min(settings.max_frequency_hz or reach, 0.5 * spectra.record.rate_hz)
    if high - low < 16.0 / spectra.length_s:
        raise IdentificationError(
            'band too narrow',
            found=f'{low:.4g} to {high:.4g} Hz, lines {1.0 / spectra.length_s:.3g} Hz apart',
            advice='the force reaches no higher: a harder tip, or longer between taps',
        )
    return low, high


def _reported(model: ModalModel, band_hz: tuple[float, float], length_s: float) -> list[int]:
    """Return which poles are modes, by frequency."""
    frequency = np.abs(model.pole) / (2.0 * np.pi)
    damping = -model.pole.real / np.abs(model.pole)
    inside = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    inside &= (damping > 0.0) & (damping < IMPACT.most_damping)
    inside &= -model.pole.real * length_s > LEAST_DECAY
    reported = np.flatnonzero(inside)
    return [int(each) for each in reported[np.argsort(frequency[reported])]]


def _result(
    data: Sequence[PointData],
    model: ModalModel,
    passed: tuple[MeasuringChain, Sequence[DrivingSign]],
    band_hz: tuple[float, float],
    length_s: float,
) -> ImpactResult:
    chain, signs = passed
    reported = _reported(model, band_hz, length_s)
    scatter = taps_differ(data, model)
    modes = scaled_modes(data, model, reported, length_s, chain, scatter)
    pole = np.concatenate([model.pole[reported], np.delete(model.pole, reported)])
    places = model.places
    points = tuple(
        TestedPoint(
            name=each.frf.spectra.record.name,
            hit=each.frf.spectra.record.hit,
            taps=each.frf.spectra.taps,
            data=each,
            synthesised=synthesised(each, model.pole, model.amplitude(number)),
        )
        for number, each in enumerate(data)
    )
    return ImpactResult(
        scaled_modes=modes,
        places=places.names[places.shown],
        points=points,
        band_hz=band_hz,
        length_s=length_s,
        misfit=model.misfit,
        driving_phase_deg=driving_phases(data, free_fit(data, pole), pole[: len(reported)]),
        reciprocity=reciprocity(points),
        remarks=(
            *remarks_on_chain(chain),
            *remarks_on_signs(signs),
            *remarks_on_taps(points, modes, scatter[1][:, reported]),
            *remarks_on(
                points,
                modes,
                places,
                misfit=model.misfit,
                length_s=length_s,
                told=[each.point for each in signs if each.mixed],
            ),
            *remarks_on_peaks(data, model.pole[reported]),
        ),
    )


def _without_unlike(spectra: PointSpectra) -> PointSpectra:
    """Leave out taps whose answers are not those of the others, where three remain."""
    unlike: NDArray[np.float64] = PointFrf(spectra).unlikeness()
    worst = int(np.argmax(unlike))
    if unlike[worst] <= IMPACT.unlike or spectra.n_taps <= FEWEST_TAPS + 1:
        return spectra
    good = [number for number, each in enumerate(spectra.taps) if each.good]
    taps = list(spectra.taps)
    how = f'its answer differs {unlike[worst]:.0f} times as much'
    taps[good[worst]] = taps[good[worst]].with_fault(Fault.UNLIKE, how)
    fresh = PointSpectra.of(spectra.record, taps, spectra.length_s, spectra.decay_1_s)
    return _without_unlike(fresh)


def _check_rates(records: Sequence[ImpactRecord]) -> None:
    if not records:
        raise IdentificationError('no recording of taps')
    rates = {record.rate_hz for record in records}
    if max(rates) - min(rates) > 1e-6 * max(rates):
        raise IdentificationError(
            'sample rates differ', found=', '.join(f'{rate:g} Hz' for rate in sorted(rates))
        )


def _check_taps(record: ImpactRecord, taps: Sequence[JudgedTap], unnamed: bool) -> None:
    good = sum(each.good for each in taps)
    if good >= FEWEST_TAPS:
        return
    advice = ''
    if any(each.has(Fault.TOO_CLOSE) for each in taps):
        advice = 'wait until the structure rests between taps, 3 s or more'
    elif good and unnamed:
        advice = 'where each tap has a file, say which point they hit: those of one are joined'
    why = '; '.join(f'tap {number}: {t.words}' for number, t in enumerate(taps, 1) if not t.good)
    raise IdentificationError(
        'too few good taps',
        where=record.name,
        found=f'{good} of {len(taps)}' + (f' ({why})' if why else ''),
        expected=f'{FEWEST_TAPS} at least, for coherence and standard deviations; 5 are better',
        advice=advice,
    )
