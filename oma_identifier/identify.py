"""Identification of a stretch of samples: bands, poles, selection, modes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from modal_core.channel import Channel
from modal_core.errors import IdentificationError
from modal_core.indicators import mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleStatus, PoleTable
from modal_core.quality import DataQuality
from modal_core.samples import Samples
from oma_identifier.covariance import Band, Decimation, plan_bands, WhenFull
from oma_identifier.motion import never, PeakTest
from oma_identifier.one_thread import one_thread
from oma_identifier.refinement import adopt_refined, Adopted
from oma_identifier.result import WindowResult
from oma_identifier.selection import (
    BandSelection,
    BandSelector,
    NewModeTest,
    SelectedPole,
    without_doubtful,
    without_repeats,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import (
    CHANCE,
    CHANCE_SHARP,
    Line,
    line_at,
    LineEvidence,
    singular_value_spectrum,
    SpectralPeaks,
    SUSPECT_DAMPING,
    without_lines,
)
from oma_identifier.subspace import BandCovariance, BandStream

FEW_ROWS = 1000
SAME_LINE = 0.003
TOO_CERTAIN = 0.7
"""Blur in multiples of the least that a mode under random forces can have."""
NO_MODE = 'no mode stands out from the noise'
ONLY_LINES = 'only harmonics: no mode stands out beside them'
LineTest = Callable[[float], Line | None]
Adopt = Callable[[Samples, ModeSet, ModeSet], Adopted]


@dataclass(frozen=True, slots=True)
class Identified:
    """Modes and poles of one stretch.

    Parameters
    ----------
    modes, harmonics : ModeSet
        Of the structure; of machines and drives.
    poles : PoleTable
        All poles; ``mode_id`` is the position in ``modes``, counted from 1.
    """

    modes: ModeSet
    harmonics: ModeSet
    poles: PoleTable


def identify_samples(
    samples: Samples,
    settings: IdentificationSettings | None = None,
    progress: Callable[[float], None] | None = None,
) -> WindowResult:
    """Identify the modes of one uniformly sampled stretch.

    Parameters
    ----------
    samples : Samples
        Responses to excitation that nobody measured; at least some tens of periods.
    settings : IdentificationSettings or None
        None: the defaults.
    progress : callable or None
        Called with the share of the work done.

    Returns
    -------
    WindowResult
        Without modes, and saying why, when the stretch cannot be identified.

    Raises
    ------
    IdentificationError
        The stretch is too short for the band asked for.
    """
    settings = settings or IdentificationSettings()
    check_samples(samples)
    selector = BandSelector()
    with one_thread():
        sources = _sources(samples, settings, progress)
        test_line, peaks = line_tester(samples), SpectralPeaks(samples)
        found = identify_bands(
            sources, samples.channels, settings, test_line, never, peaks, selector
        )
        evidence = line_evidence(samples, found)
        found = without_explained(found, evidence)
        if settings.refines:
            found = refine_found(samples, found, sources, settings, selector=selector)
            found = without_explained(found, evidence)
        highest_hz = plan_bands(samples.sample_rate_hz, samples.duration_s, settings)[0].high_hz
        spectrum = singular_value_spectrum(samples, highest_hz)
    return WindowResult(
        index=-1,
        start_ns=samples.start_ns,
        end_ns=samples.end_ns,
        modes=found.modes,
        harmonics=found.harmonics,
        poles=found.poles,
        spectrum=spectrum,
        quality=explain(DataQuality(), found),
    )


def _sources(
    samples: Samples,
    settings: IdentificationSettings,
    progress: Callable[[float], None] | None = None,
) -> list[BandCovariance | None]:
    bands = plan_bands(samples.sample_rate_hz, samples.duration_s, settings)
    rows = Decimation()
    rows.take(samples.acceleration)
    sources = []
    for done, band in enumerate(bands):
        sources.append(_source(band, samples, rows, settings))
        if progress is not None:
            progress((done + 1) / len(bands))
    return sources


def _source(
    band: Band, samples: Samples, rows: Decimation, settings: IdentificationSettings
) -> BandCovariance | None:
    stream = BandStream(band, settings, samples.duration_s, WhenFull.JOIN)
    stream.add(rows)
    return stream.result()


def line_tester(samples: Samples, removed: ModeSet | None = None) -> LineTest:
    """Return a test for lines of samples, which knows the lines removed from them.

    What a line that wavers leaves behind is an image of it still.
    """

    def test(frequency_hz: float) -> Line | None:
        for line in removed or ():
            if math.isclose(line.frequency_hz, frequency_hz, rel_tol=SAME_LINE):
                return Line(line.frequency_hz, line.shape, 0.0)
        return line_at(samples, frequency_hz)

    return test


def refine_found(
    samples: Samples,
    found: Identified,
    sources: Sequence[BandCovariance | None],
    settings: IdentificationSettings,
    explains: PeakTest = never,
    adopt: Adopt = adopt_refined,
    selector: BandSelector | None = None,
) -> Identified:
    """Return what was found more precisely, at more cost.

    Modes under a line are biased by it: the bands that see one are identified once more without
    it.  Then the modes are refined by maximum likelihood.

    Parameters
    ----------
    samples : Samples
        What the modes were identified from.
    found : Identified
        Of these samples.
    sources : sequence of BandCovariance or None
        What it was found in.
    settings : IdentificationSettings
        As for the first identification.
    explains : callable
        As for :func:`identify_bands`.
    adopt : callable
        Refines the modes of samples with lines.
    selector : BandSelector or None
        As for :func:`identify_bands`.
    """
    if len(found.harmonics):
        lines_hz = found.harmonics.frequency_hz
        samples = without_lines(samples, tuple(lines_hz))
        rows = Decimation()
        rows.take(samples.acceleration)
        freed = [
            _source(source.band, samples, rows, settings)
            if source is not None and source.band.sees(lines_hz).any()
            else source
            for source in sources
        ]
        test_line, peaks = line_tester(samples, found.harmonics), SpectralPeaks(samples)
        again = identify_bands(
            freed, samples.channels, settings, test_line, explains, peaks, selector
        )
        found = replace(
            again, harmonics=found.harmonics, poles=_with_images(again.poles, found.poles)
        )
    adopted = without_doubtful(
        adopt(samples, found.modes, found.harmonics),
        NewModeTest(samples, settings, found.harmonics, explains),
    )
    return replace(found, modes=adopted.modes, poles=_renumbered(found.poles, adopted.origin))


def _renumbered(poles: PoleTable, origin: tuple[int, ...]) -> PoleTable:
    """Return the poles with the numbers that their modes have now; new modes have no poles."""
    number = np.zeros(max(0, poles.mode_id.max(initial=0), *origin) + 2, dtype=np.int64)
    for now, before in enumerate(origin, start=1):
        if before >= 0:
            number[before + 1] = now
    return replace(poles, mode_id=number[poles.mode_id])


def check_samples(samples: Samples) -> None:
    """Refuse samples that break the contract of :class:`Samples`.

    Raises
    ------
    IdentificationError
        Naming the channel that is not finite, or that nothing moves.
    """
    data = samples.acceleration
    # A sum over time is finite when all its samples are, and costs one pass.
    with np.errstate(invalid='ignore', over='ignore'):
        finite = np.isfinite(sum(np.ones(len(part)) @ part for part in samples.stretches()))
    if not finite.all():
        name = samples.channel_names[int(np.argmin(finite))]
        raise IdentificationError('not finite', where=name, expected='finite samples')
    if not (data[:FEW_ROWS] != data[:1]).any() and not (data != data[:1]).any():
        raise IdentificationError('no channel moves', expected='responses to some excitation')


def explain(quality: DataQuality, found: Identified) -> DataQuality:
    """Return the quality with the reason why there is no mode, when there is none."""
    if len(found.modes) or not quality.identifiable:
        return quality
    reason = ONLY_LINES if len(found.harmonics) else NO_MODE
    return replace(quality, identifiable=False, reason=reason)


def line_evidence(samples: Samples, found: Identified) -> LineEvidence:
    """Return what tells the modes found in samples from the leakage of lines."""
    return LineEvidence.of(samples, tuple(found.harmonics.frequency_hz), found.modes)


def without_explained(found: Identified, evidence: LineEvidence | None) -> Identified:
    """Return what was found without the modes that lines explain."""
    if evidence is None:
        return found
    kept = [index for index, mode in enumerate(found.modes) if not evidence.explains(mode)]
    return found if len(kept) == len(found.modes) else _kept(found, kept)


def without_modes(found: Identified) -> Identified:
    """Return what was found as if lines explained all of its modes."""
    return _kept(found, [])


def _kept(found: Identified, kept: Sequence[int]) -> Identified:
    modes = replace(found.modes, modes=tuple(found.modes.modes[index] for index in kept))
    poles = _renumbered(found.poles, tuple(kept))
    status = poles.status.copy()
    status[(found.poles.mode_id > 0) & (poles.mode_id == 0)] = PoleStatus.HARMONIC
    return replace(found, modes=modes, poles=replace(poles, status=status))


def identify_bands(
    sources: Sequence[BandCovariance | None],
    channels: Sequence[Channel],
    settings: IdentificationSettings,
    test_line: LineTest,
    explains: PeakTest = never,
    peaks: SpectralPeaks | None = None,
    selector: BandSelector | None = None,
) -> Identified:
    """Solve every band, select the modes and sort out the harmonics.

    Parameters
    ----------
    sources : sequence of BandCovariance or None
        None where a band has too little data.
    channels : sequence of Channel
        Of the covariances.
    settings : IdentificationSettings
        Orders and limits.
    test_line : callable
        Frequency [Hz] to the line there, None where nothing can be said.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.
    peaks : SpectralPeaks or None
        Of the samples behind the covariances, where they are at hand.
    selector : BandSelector or None
        Knows what it selected before from the same covariances; None: nothing.
    """
    selector = selector or BandSelector()
    selected = (
        selector.select(source, settings, peaks) for source in sources if source is not None
    )
    selections = [selection for selection in selected if selection is not None]
    names = tuple(channel.name for channel in channels)
    poles = without_repeats([pole for each in selections for pole in each.selected])
    lines = _lines(selections, poles, test_line)
    kept = [
        pole
        for pole in poles
        if not _on_line(pole, lines)
        and not explains(
            pole.frequency_hz, pole.damping_ratio * pole.frequency_hz, pole.physical_shape
        )
    ]
    modes = ModeSet(tuple(_mode(pole) for pole in kept), names, settings.method)
    harmonics = ModeSet(tuple(harmonic(line) for line in lines), names, settings.method)
    return Identified(modes, harmonics, _table(selections, kept, lines, len(names)))


def _lines(
    selections: Sequence[BandSelection], poles: Sequence[SelectedPole], test_line: LineTest
) -> list[Line]:
    """Test every frequency where poles are hardly damped."""
    suspects = [
        _Suspect(pole.frequency_hz, CHANCE_SHARP if _too_certain(pole) else CHANCE)
        for pole in poles
        if pole.damping_ratio < 2.0 * SUSPECT_DAMPING or _too_certain(pole)
    ]
    for each in selections:
        suspects += _undamped(each)
    lines: list[Line] = []
    for suspect in sorted(suspects, key=lambda suspect: suspect.frequency_hz):
        line = test_line(suspect.frequency_hz)
        if line is not None and line.chance < suspect.chance and not _known(line, lines):
            lines.append(line)
    return lines


@dataclass(frozen=True, slots=True)
class _Suspect:
    frequency_hz: float
    chance: float


def _undamped(selection: BandSelection) -> list[_Suspect]:
    """Return the frequencies where poles with hardly any damping repeat over the orders."""
    poles, band = selection.band.poles, selection.band.source.band
    frequency, damping = poles.frequency_hz, np.abs(poles.damping_ratio)
    bare = np.flatnonzero(
        (damping < SUSPECT_DAMPING) & (frequency > band.low_hz) & (frequency < band.high_hz)
    )
    if len(bare) == 0:
        return []
    bare = bare[np.argsort(frequency[bare])]
    breaks = np.flatnonzero(np.diff(frequency[bare]) > 0.002 * frequency[bare[:-1]]) + 1
    least = max(3, selection.band.n_orders // 6)
    resolution_hz = 0.5 / selection.band.source.covariance.duration_s
    suspects = []
    for run in np.split(bare, breaks):
        if len(run) < least:
            continue
        width_hz = float(np.median(damping[run] * frequency[run]))
        chance = CHANCE_SHARP if width_hz < resolution_hz else CHANCE
        suspects.append(_Suspect(float(np.median(frequency[run])), chance))
    return suspects


def _with_images(poles: PoleTable, before: PoleTable) -> PoleTable:
    """Return the poles with the images of the lines that were there before."""
    images = before.status == PoleStatus.HARMONIC
    return PoleTable(
        np.concatenate([poles.model_order, before.model_order[images]]),
        np.concatenate([poles.pole, before.pole[images]]),
        np.concatenate([poles.shape, before.shape[:, images]], axis=1),
        np.concatenate([poles.status, before.status[images]]),
        np.concatenate([poles.mode_id, before.mode_id[images]]),
    )


def with_lines(found: Identified, lines: Sequence[Mode]) -> Identified:
    """Return what was found with further harmonics, by frequency."""
    if not lines:
        return found
    merged = sorted((*found.harmonics, *lines), key=lambda line: line.frequency_hz)
    return replace(found, harmonics=replace(found.harmonics, modes=tuple(merged)))


def _known(line: Line, lines: Sequence[Line]) -> bool:
    return any(
        math.isclose(line.frequency_hz, other.frequency_hz, rel_tol=SAME_LINE) for other in lines
    )


def _on_line(pole: SelectedPole, lines: Sequence[Line]) -> bool:
    """Tell whether a pole is the image of a line: as sharp or as certain as one, at its place."""
    reach = max(2.0 * SUSPECT_DAMPING, pole.damping_ratio)
    like = pole.damping_ratio < 2.0 * SUSPECT_DAMPING or _too_certain(pole)
    return like and any(abs(line.frequency_hz / pole.frequency_hz - 1.0) < reach for line in lines)


def _too_certain(pole: SelectedPole) -> bool:
    """Tell whether a pole scatters less than the response to any random force allows."""
    return pole.from_limit < TOO_CERTAIN


def _mode(pole: SelectedPole) -> Mode:
    shape = normalise(pole.physical_shape)
    return Mode(
        frequency_hz=pole.frequency_hz,
        damping_ratio=pole.damping_ratio,
        shape=shape,
        frequency_std_hz=pole.deviation.frequency_std_hz,
        damping_ratio_std=pole.deviation.damping_ratio_std,
        mpc=float(mpc(pole.shape[:, None])[0]),
        mpd=float(mpd(pole.shape[:, None])[0]),
    )


def harmonic(line: Line) -> Mode:
    """Return a line as a mode without damping, marked harmonic."""
    shape = normalise(line.shape)
    return Mode(
        frequency_hz=line.frequency_hz,
        damping_ratio=0.0,
        shape=shape,
        mpc=float(mpc(shape[:, None])[0]),
        mpd=float(mpd(shape[:, None])[0]),
        harmonic=True,
    )


def _table(
    selections: Sequence[BandSelection],
    kept: Sequence[SelectedPole],
    lines: Sequence[Line],
    n_channels: int,
) -> PoleTable:
    """Join the poles of all bands; poles outside a band's own range are left to its neighbour."""
    orders, poles, shapes, status, ids = [], [], [], [], []
    for each in selections:
        table = each.band.poles
        verdict = each.status.copy()
        mode_id = np.zeros(len(verdict), dtype=np.int64)
        verdict[verdict == PoleStatus.KEPT] = PoleStatus.CLUSTER_OUTLIER
        for number, pole in enumerate(kept, start=1):
            if pole.band is each.band:
                mode_id[pole.cluster.members] = number
                verdict[pole.cluster.members] = PoleStatus.KEPT
        for line in lines:
            near = np.abs(table.frequency_hz / line.frequency_hz - 1.0) < SUSPECT_DAMPING
            near &= np.abs(table.damping_ratio) < 2.0 * SUSPECT_DAMPING
            verdict[near & (mode_id == 0)] = PoleStatus.HARMONIC
        inside = verdict != PoleStatus.OUT_OF_BAND
        orders.append(table.model_order[inside])
        poles.append(table.pole[inside])
        shapes.append(table.shape[:, inside] * each.band.source.scale[:, None])
        status.append(verdict[inside])
        ids.append(mode_id[inside])
    if not selections:
        return no_poles(n_channels)
    return PoleTable(
        np.concatenate(orders),
        np.concatenate(poles),
        np.concatenate(shapes, axis=1),
        np.concatenate(status),
        np.concatenate(ids),
    )


def no_poles(n_channels: int) -> PoleTable:
    """Return an empty table."""
    return PoleTable(
        np.empty(0, dtype=np.int64),
        np.empty(0, dtype=complex),
        np.empty((n_channels, 0), dtype=complex),
        np.empty(0, dtype=np.uint8),
        np.empty(0, dtype=np.int64),
    )
