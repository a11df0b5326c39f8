"""The findings in plain words."""

from collections.abc import Sequence

from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.number_text import deviation_text, fixed, value_text
from autonomous_modal_analysis.report.truth import TrueMode
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.poles import PoleStatus
from modal_core.quality import ChannelQuality, DataQuality
from oma_identifier.covariance import AnalysedBand

STATUS_WORDS = {
    PoleStatus.KEPT: 'belongs to a mode',
    PoleStatus.UNSTABLE_POLE: 'negative damping',
    PoleStatus.OVERDAMPED: 'damping above the limit',
    PoleStatus.OUT_OF_BAND: 'outside the analysed band',
    PoleStatus.FREQUENCY_NOT_STABLE: 'frequency differs from the order below',
    PoleStatus.DAMPING_NOT_STABLE: 'damping differs from the order below',
    PoleStatus.SHAPE_NOT_STABLE: 'shape differs from the order below',
    PoleStatus.UNCERTAIN: 'standard deviation too large',
    PoleStatus.COMPLEX_SHAPE: 'phases scatter too much for a mode',
    PoleStatus.SMALL_CLUSTER: 'too few orders agree',
    PoleStatus.HARMONIC: 'line of a machine or drive, not a mode',
    PoleStatus.CLUSTER_OUTLIER: 'far from the centre of its mode',
    PoleStatus.WEAK: 'contributes no more than noise',
}

FLAG_WORDS = {
    'flatline': 'no signal (flat line)',
    'clipping': 'signal clipped at the sensor range',
    'not_finite': 'values that are not numbers',
    'gap': 'gaps in the data',
    'degraded': 'identified from fewer channels than expected',
    'partial': 'shorter than a full window',
    'rate_change': 'sample rate changed',
    'clock_jump': 'clock jumped',
    'unit_g_suspicion': 'gravity reads 1: perhaps in g instead of m/s²',
    'gravity_suspicion': 'gravity has the wrong length: check gain and unit',
    'rigid_motion_mismatch': "does not fit the robot's motion: check polarity, axes and place",
    'not_synchronous': 'sampled later or earlier than the other sensors',
    'rigid_motion_removed': 'rigid motion of the arm taken out',
    'drive_lines': 'lines of the drives taken out',
    'gross_motion': 'the robot moved far',
}


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
    listed = []
    if windows:
        seconds = (windows[-1].end_ns - windows[0].start_ns) / NANOSECONDS_PER_SECOND
        listed += [duration(seconds), count(len(windows), 'window')]
    used = len(identification.modes.channel_names)
    expected = max(used, len(identification.channels), len(identification.quality.channels))
    listed.append(count(used, 'channel') if used == expected else f'{used} of {expected} channels')
    rates = [quality.measured_rate_hz for quality in identification.quality.channels]
    rates = sorted(rate for rate in rates if rate > 0.0)
    if rates:
        listed.append(f'{rates[len(rates) // 2]:.4g} Hz sample rate')
    if identification.band is not None:
        listed.append(band_words(identification.band))
    harmonics = sum(mode.harmonic for mode in identification.modes)
    harmonics += len(identification.harmonics)
    if harmonics:
        listed.append(f'{count(harmonics, "harmonic")} set apart')
    return listed


def band_words(band: AnalysedBand) -> str:
    """Return where modes were looked for, and why not above when a plan tells."""
    text = f'band {band.low_hz:.3g} to {band.high_hz:.3g} Hz'
    return f'{text}, below the edge of the excitation' if band.high_from == 'plan' else text


def quality_words(quality: DataQuality) -> list[str]:
    """Return the health of the data in sentences, the most important first."""
    sentences = []
    if not quality.identifiable:
        reason = quality.reason or 'no reason was recorded'
        sentences.append(f'The data could not be identified: {reason}.')
    sentences += [f'{_capital(flag_words(flag))}.' for flag in quality.flags]
    excluded = [channel.name for channel in quality.channels if channel.excluded]
    if excluded:
        verb = 'was' if len(excluded) == 1 else 'were'
        sentences.append(f'{_listed(excluded)} {verb} left out of the identification.')
    lost = sum(channel.n_lost for channel in quality.channels)
    filled = sum(channel.n_interpolated for channel in quality.channels)
    if lost:
        sentences.append(f'{count(lost, "sample")} never arrived, {filled} of them filled in.')
    elif filled:
        sentences.append(f'{count(filled, "sample")} filled in across short gaps.')
    repeated = sum(channel.n_duplicates for channel in quality.channels)
    moved = sum(channel.n_reordered for channel in quality.channels)
    if repeated:
        sentences.append(f'{count(repeated, "repeated sample")} dropped.')
    if moved:
        sentences.append(f'{count(moved, "sample")} arrived out of order and put back.')
    if not sentences and not any(channel.flags for channel in quality.channels):
        sentences.append('No fault was found in the data.')
    return sentences


def channel_words(channel: ChannelQuality) -> str:
    """Return what was found on one channel."""
    found = [flag_words(flag) for flag in channel.flags]
    if channel.excluded:
        found.insert(0, 'left out')
    return ', '.join(found) or 'healthy'


def flag_words(flag: str) -> str:
    """Return a flag in words."""
    return FLAG_WORDS.get(flag, flag.replace('_', ' '))


def count(number: int, noun: str) -> str:
    """Return a number with its noun in the right number."""
    return f'{number} {noun}' if number == 1 else f'{number} {noun}s'


def duration(seconds: float) -> str:
    """Return a length of time in the unit a person would choose."""
    if seconds < 120.0:
        return f'{seconds:.3g} s of data'
    if seconds < 7200.0:
        return f'{seconds / 60.0:.3g} min of data'
    return f'{seconds / 3600.0:.3g} h of data'


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
        error = fixed(100.0 * abs(worst.frequency_error), 2)
        which = 'the' if len(pairs) == 1 else 'the largest'
        sentence += f'; {which} frequency error is {error} %{of_sigma}'
    if missed:
        sentence += f'. Missed: {_listed([f"{true.frequency_hz:.4g} Hz" for true in missed])}'
    n_extra = n_modes - (len(pairs) - n_single)
    if n_extra:
        sentence += f'. {count(n_extra, "further mode")} without a true one'
    return sentence + '.'


def _frequency(mode: Mode) -> str:
    text = value_text(mode.frequency_hz, mode.frequency_std_hz)
    if mode.frequency_std_hz > 0.0:
        text += f' ± {deviation_text(mode.frequency_hz, mode.frequency_std_hz)}'
    return f'{text} Hz'


def _listed(names: Sequence[str], most: int = 5) -> str:
    shown = list(names[:most])
    if len(names) > most:
        shown.append(f'{len(names) - most} more')
    return shown[0] if len(shown) == 1 else f'{", ".join(shown[:-1])} and {shown[-1]}'


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
