"""The findings in plain words."""

from collections.abc import Sequence

from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.truth import TrueMode
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_reports import count, duration, fixed, FREQUENCY, listed, percent
from oma_identifier.covariance import AnalysedBand


def headline(content: ReportContent) -> str:
    """Return what was found, in one sentence."""
    identification = content.identification
    modes = [mode for mode in identification.modes if not mode.harmonic]
    if not modes:
        reason = identification.quality.reason
        return f'No mode could be identified{f": {reason}" if reason else ""}.'
    if content.truth:
        return _against_truth(content.truth, len(modes))
    if len(modes) == 1:
        return f'One mode of vibration was found, at {_frequency(modes[0])}.'
    return (
        f'{len(modes)} modes of vibration were found, '
        f'from {_frequency(modes[0])} to {_frequency(modes[-1])}.'
    )


def facts(content: ReportContent) -> list[str]:
    """Return the size of the job in a few short facts."""
    identification = content.identification
    windows = identification.windows
    told = []
    if windows:
        seconds = (windows[-1].end_ns - windows[0].start_ns) / NANOSECONDS_PER_SECOND
        told += [duration(seconds), count(len(windows), 'window')]
    used = len(identification.modes.channel_names)
    expected = max(used, len(identification.channels), len(identification.quality.channels))
    told.append(count(used, 'channel') if used == expected else f'{used} of {expected} channels')
    rates = [quality.measured_rate_hz for quality in identification.quality.channels]
    rates = sorted(rate for rate in rates if rate > 0.0)
    if rates:
        told.append(f'{rates[len(rates) // 2]:.4g} Hz sample rate')
    if identification.band is not None:
        told.append(band_words(identification.band))
    harmonics = sum(mode.harmonic for mode in identification.modes)
    harmonics += len(identification.harmonics)
    if harmonics:
        told.append(f'{count(harmonics, "harmonic")} set apart')
    return told


def band_words(band: AnalysedBand) -> str:
    """Return where modes were looked for, and why not above when a plan tells."""
    text = f'band {band.low_hz:.3g} to {band.high_hz:.3g} Hz'
    return f'{text}, below the edge of the excitation' if band.high_from == 'plan' else text


def _against_truth(truth: Sequence[TrueMode], n_modes: int) -> str:
    pairs = [true for true in truth if true.mode is not None]
    n_single = sum(true.from_window for true in pairs)
    missed = [true for true in truth if true.mode is None]
    found = f'All {len(truth)}' if not missed else f'{len(pairs)} of {len(truth)}'
    if len(truth) == 1:
        found = 'The one' if pairs else 'Not the one'
    sentence = f'{found} true {"mode" if len(truth) == 1 else "modes"} found'
    if n_single:
        sentence += f', {n_single} in a single window only'
    if pairs:
        worst = max(pairs, key=lambda pair: abs(pair.frequency_error))
        sigma = worst.frequency_error_sigma
        of_sigma = f', {fixed(abs(sigma), 1)} σ' if sigma == sigma else ''
        which = 'the' if len(pairs) == 1 else 'the largest'
        error = percent(abs(worst.frequency_error), 2)
        sentence += f'; {which} frequency error is {error}{of_sigma}'
    if missed:
        sentence += f'. Missed: {listed([f"{true.frequency_hz:.4g} Hz" for true in missed])}'
    n_extra = n_modes - (len(pairs) - n_single)
    if n_extra:
        sentence += f'. {count(n_extra, "further mode")} without a true one'
    return sentence + '.'


def _frequency(mode: Mode) -> str:
    return FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz)
