"""What speaks for or against a tap test: driving points, reciprocity, synthesised FRFs."""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit import FreePoint, Places
from impact_testing.measuring_chain import MeasuringChain
from impact_testing.modes import nearer_than_told, rings, TOLD_DECAY
from impact_testing.record import ImpactRecord
from impact_testing.responses import at_rest_before, PointData
from impact_testing.result import frac, ScaledMode, TestedPoint
from impact_testing.steady_lines import Cleared
from impact_testing.thresholds import IMPACT
from impact_testing.unexplained import unexplained_peaks
from modal_core.mode import Mode
from modal_core.words.named import named
from oma_identifier.quality import QUALITY, times_of_alike

Complex = NDArray[np.complex128]
MODEL_SHORT = 2.0
"""Mean square misfit beyond which modes and noise do not explain the FRFs."""


def driving_phases(
    data: Sequence[PointData], free: Sequence[FreePoint], pole: Complex
) -> dict[str, tuple[float, ...]]:
    """Return the phase of 2jω_d R at each driving point [deg], by mode; 0 of a real mode.

    Parameters
    ----------
    data, free : sequences, one entry per point
    pole : (n_modes,) complex array [rad/s]
        By frequency, as the amplitudes are.
    """
    found = {}
    for each, point in zip(data, free, strict=True):
        record = each.frf.spectra.record
        if record.point in each.frf.spectra.names:
            column = each.frf.spectra.names.index(record.point)
            residue = point.amplitude[: len(pole), column] / pole**2
            phase = np.degrees(np.angle(2j * pole.imag * residue))
            found[record.point] = tuple(phase.tolist())
    return found


def reciprocity(points: Sequence[TestedPoint]) -> dict[str, float]:
    """Return FRAC of the FRFs between two points, both of which were hit and have channels."""
    found = {}
    for number, first in enumerate(points):
        for second in points[number + 1 :]:
            p, q = first.hit.removeprefix('-'), second.hit.removeprefix('-')
            names, others = first.data.frf.spectra.names, second.data.frf.spectra.names
            if p != q and q in names and p in others:
                one = first.measured[:, [names.index(q)]]
                other = second.measured[:, [others.index(p)]]
                found[f'{p} and {q}'] = float(frac(one, other)[0])
    return found


def remarks_on(
    points: Sequence[TestedPoint],
    modes: Sequence[ScaledMode],
    places: Places,
    misfit: float,
    length_s: float,
    told: Sequence[int] = (),
) -> tuple[str, ...]:
    """Return what should be known, each with a remedy; of some points it was told elsewhere."""
    said = []
    if not places.tied:
        hits = ', '.join(
            dict.fromkeys(
                point.hit for n, point in enumerate(points) if point.hit and n not in places.loose
            )
        )
        names = named(places.names[: places.n_channels], 3)
        said.append(
            'no driving point'
            + (f' ({hits} is none of the channels {names})' if hits else '')
            + ': masses are not known; put a sensor where the hammer strikes and name it as the'
            ' point hit'
        )
    if misfit > MODEL_SHORT:
        said.append(
            f'modes and noise leave {misfit:.1f} times the noise: the structure is not linear or'
            ' not at rest, or modes are missing or ring on from tap to tap (longer pauses help);'
            ' standard deviations are widened by it'
        )
    bad = sum(not tap.good for point in points for tap in point.taps)
    if bad:
        said.append(f'{bad} of {sum(len(point.taps) for point in points)} taps left out')
    few = [point.name for point in points if point.n_good < 3]
    if few:
        said.append(f'two good taps only ({", ".join(few[:3])}): coherence says little')
    loose = [points[number].hit for number in sorted(set(places.loose) - set(told))]
    if loose:
        said.append(
            f'taps named {", ".join(loose)} did not hit the place of that channel in its'
            ' direction: they have a place of their own; swap the sign before the channel or'
            ' name the place they hit'
        )
    moving = [each.name for each in points if not at_rest_before(each.data.frf.spectra)]
    if moving:
        said.append(
            f'the structure still moves when recordings begin ({named(moving, 3)}), so no mode has'
            ' a σ: wait until it rests before each tap, or record without a trigger'
        )
    else:
        said.extend(_without_deviations(modes, length_s))
    if any(each.mode.frequency_std_hz > 0.5 * each.mode.frequency_hz for each in modes):
        said.append('some modes are not determined by these taps')
    return tuple(said)


def remarks_on_taps(
    points: Sequence[TestedPoint], modes: Sequence[ScaledMode], scatter: NDArray[np.float64]
) -> tuple[str, ...]:
    """Return what is to be said of points whose taps hit several.

    Parameters
    ----------
    points, modes : sequences
    scatter : (n_points, n_modes) array
        By how much modes differ from tap to tap beyond the noise, as shares.
    """
    said = []
    for point, shares in zip(points, scatter, strict=True):
        apart = np.flatnonzero(shares > IMPACT.one_point).tolist()
        if not apart:
            continue
        at = named([f'{modes[mode].mode.frequency_hz:.4g}' for mode in apart], 3)
        several = 2 * len(apart) > len(modes)
        why = 'they hit several points or directions' if several else 'they hit near a node of it'
        said.append(
            f'taps of {point.name} differ by {100.0 * shares.max():.0f} % in modes at {at} Hz:'
            f' {why}, so no mass is told there; '
            + ('record each point by itself' if several else 'hit another point')
        )
    return tuple(said)


def remarks_on_peaks(data: Sequence[PointData], pole: Complex) -> tuple[str, ...]:
    """Return what is to be said of measured peaks that no mode explains.

    Parameters
    ----------
    data : sequence of PointData
    pole : (n_modes,) complex array [rad/s]
        Of the modes that are reported.
    """
    said = []
    peaks = unexplained_peaks(data, pole)
    if peaks:
        several = len(peaks) > 1
        at = ', '.join(f'{each:.4g}' for each in peaks)
        said.append(
            f'{"peaks" if several else "a peak"} at {at} Hz {"are" if several else "is"} not'
            ' explained by the modes: a mode is missing there, or wrong; longer pauses between'
            ' taps tell'
        )
    return tuple(said)


def remarks_on_units(records: Sequence[ImpactRecord]) -> tuple[str, ...]:
    """Return what is to be said of units that nobody stated."""
    taken = {'the force': 'newtons', 'the responses': 'm/s²'}
    said = []
    for whose, unit in taken.items():
        names = [each.name for each in records if whose in each.without_unit]
        if names:
            said.append(
                f'no unit of {whose} is stated ({named(names, 3)}): taken as {unit}; masses are as'
                ' wrong as that is, so they have no σ: name the unit of each column'
            )
    return tuple(said)


def remarks_on_sizes(records: Sequence[ImpactRecord]) -> tuple[str, ...]:
    """Return what is to be said of sensors far larger or smaller than the others."""
    far: dict[str, float] = {}
    for record in records:
        channels = record.responses.channels
        size = record.responses.widened().std(axis=0)
        sizes = times_of_alike(size.tolist(), [channel.unit for channel in channels])
        for channel, times in zip(channels, sizes.tolist(), strict=True):
            usual = 1.0 / QUALITY.small_factor < times < QUALITY.small_factor
            if math.isfinite(times) and not usual:
                far[channel.name] = times
    return tuple(
        f'{name} reads {times:.2g} times what the other sensors do: check its unit and gain;'
        ' masses and shapes are as wrong as these'
        for name, times in far.items()
    )


def remarks_on_lines(cleared: Sequence[Cleared]) -> tuple[str, ...]:
    """Return what is to be said of lines that are there without a tap."""
    told = (
        (
            [each.taken_hz for each in cleared],
            'hum',
            'without a tap: that was taken out of force and responses',
        ),
        (
            [each.left_hz for each in cleared],
            'move',
            'before the first tap: that was left in, for behind the taps it is no steady line, or'
            ' is not told from what rings',
        ),
        (
            [each.too_soon_hz for each in cleared],
            'hum',
            'in the force: that was left in; half a second of rest before the first tap would tell'
            ' the line',
        ),
    )
    said = []
    for lines_hz, verb, rest in told:
        names = [each.record.name for each, lines in zip(cleared, lines_hz, strict=True) if lines]
        every = dict.fromkeys(f'{each:.4g}' for each in sorted(sum(lines_hz, ())))
        verb += 's' if len(names) == 1 else ''
        if names:
            said.append(f'at {named(list(every), 5)} Hz {named(names, 3)} {verb} {rest}')
    return tuple(said)


def remark_on_drift(drift_n: float) -> tuple[str, ...]:
    """Return what is to be said of a force whose rest drifted by so much [N]."""
    if not drift_n:
        return ()
    return (f'the force drifts by {drift_n:.2g} N without a tap: that was taken out',)


def remarks_on_chain(chain: MeasuringChain) -> tuple[str, ...]:
    """Return what is to be said of what the measuring chain did, and was taken out."""
    said = []
    corners = (('the force', chain.of_force), ('the responses', chain.of_responses))
    passed = [f'{what} one of {each.hz:.2g} Hz' for what, each in corners if each.sure]
    if passed:
        said.append(
            f'force or responses passed a high-pass ({", ".join(passed)}), as couplings by'
            ' alternating current are: it was undone; couple both directly where sensors allow it'
        )
    delay = chain.delay
    if delay.sure:
        size, std = 1e3 * abs(delay.seconds), 1e3 * delay.std_s
        digits = max(0, 1 - int(np.floor(np.log10(max(std, 1e-6)))))
        said.append(
            f'the force comes {size:.{digits}f} ± {std:.{digits}f} ms'
            f' {"later" if delay.seconds > 0.0 else "earlier"} than the responses: that was taken'
            ' out; measure both through converters and filters of one kind'
        )
    return tuple(said)


def _without_deviations(modes: Sequence[ScaledMode], length_s: float) -> list[str]:
    """Return what took the deviations from modes: other taps, each other, or what is none."""
    each = [mode.mode for mode in modes]
    damping = np.array([mode.damping_ratio for mode in each])
    size = 2.0 * np.pi * np.array([mode.frequency_hz for mode in each])
    pole = size * (-damping + 1j * np.sqrt(1.0 - damping**2))
    without = np.isnan([mode.frequency_std_hz for mode in each])
    near, ringing = nearer_than_told(pole) & without, rings(pole, length_s) & without
    said = []
    if ringing.any():
        needed_s = TOLD_DECAY / float((damping * size)[ringing].min())
        whose = 'no mode has a' if without.all() else 'these have no'
        said.append(
            f'modes at {_listed(each, ringing)} Hz ring on to the end of each segment, so {whose}'
            f' σ: pauses of {needed_s:.2g} s after each tap tell'
        )
        if without.all():
            return said
    near &= ~ringing
    if near.any():
        said.append(
            f'modes at {_listed(each, near)} Hz lie within their half-widths: another'
            ' pair may explain the FRFs as well, so these have no σ; points that show one of them'
            ' alone tell'
        )
    under = without & ~near & ~ringing
    if under.any():
        said.append(
            f'over modes at {_listed(each, under)} Hz lies something broad that is no'
            ' mode, so these have no σ: FRFs that are no sum of modes, as of clipped or disturbed'
            ' responses, or too few taps'
        )
    return said


def _listed(modes: Sequence[Mode], which: NDArray[np.bool_]) -> str:
    return ', '.join(f'{modes[n].frequency_hz:.4g}' for n in np.flatnonzero(which).tolist())
