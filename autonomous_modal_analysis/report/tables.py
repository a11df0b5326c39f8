"""Rows of the report's tables, as text ready to print."""

from dataclasses import dataclass
import math

from autonomous_modal_analysis.mode_marks import HARMONIC, mark, SCATTERED
from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.number_text import (
    deviation_text,
    fixed,
    significant,
    UNKNOWN,
    value_text,
)
from autonomous_modal_analysis.report.truth import TrueMode
from autonomous_modal_analysis.report.words import channel_words
from modal_core.mode import Mode
from modal_core.quality import ChannelQuality

PERCENT = 100.0


@dataclass(frozen=True, slots=True)
class Measure:
    """A value with its deviation and, when the truth is known, its error.

    Parameters
    ----------
    value, std : str
        Rounded together.
    bar : float
        Relative deviation over the largest in the table, 0..1; NaN without one.
    true : str
        True value.
    error_sigma : float
        Error in standard deviations; NaN when not known.
    error : str
        Error in per cent of the truth.
    """

    value: str
    std: str
    bar: float
    true: str = UNKNOWN
    error_sigma: float = math.nan
    error: str = UNKNOWN

    @property
    def error_sigma_text(self) -> str:
        """Error in standard deviations, in words of one decimal."""
        return fixed(self.error_sigma, 1, sign=True)


@dataclass(frozen=True, slots=True)
class ModeRow:
    """One line of the modes table.

    Parameters
    ----------
    label : str
        Id of the mode.
    frequency, damping : Measure
        In Hz and per cent.
    mpc, mpd, mac : str
        MPD in degrees.
    note : str
        ``harmonic``, ``missed``, ``extra`` (no true mode belongs to it), ``one window`` (the whole
        recording does not show it) or nothing.
    scattered : bool
        The phases of the shape scatter.
    """

    label: str
    frequency: Measure
    damping: Measure
    mpc: str
    mpd: str
    mac: str
    note: str
    scattered: bool = False


def mode_rows(content: ReportContent) -> list[ModeRow]:
    """Return one row per identified mode, harmonic and missed true mode, by frequency."""
    truth = content.truth or ()
    single = [true.mode for true in truth if true.mode is not None and true.from_window]
    modes = [*content.identification.modes, *content.identification.harmonics, *single]
    by_mode = {id(true.mode): true for true in truth if true.mode is not None}
    widest_f = max((_relative(m.frequency_std_hz, m.frequency_hz) for m in modes), default=0.0)
    widest_d = max((_relative(m.damping_ratio_std, m.damping_ratio) for m in modes), default=0.0)
    rows = [
        (
            mode.frequency_hz,
            _row(mode, by_mode.get(id(mode)), widest_f, widest_d, known=content.truth is not None),
        )
        for mode in modes
    ]
    rows += [(true.frequency_hz, _missed(true)) for true in truth if true.mode is None]
    return [row for _, row in sorted(rows, key=lambda pair: pair[0])]


def channel_rows(channels: tuple[ChannelQuality, ...]) -> list[dict[str, str]]:
    """Return one row per channel of the data-quality table."""
    return [
        {
            'name': channel.name,
            'state': channel_words(channel),
            'bad': 'bad' if channel.excluded or channel.flags else '',
            'rate': significant(channel.measured_rate_hz, 5),
            'jitter': significant(1e6 * channel.jitter_std_s),
            'rms': significant(channel.rms),
            'noise': significant(channel.noise_rms),
            'kurtosis': significant(channel.kurtosis),
            'filled': str(channel.n_interpolated),
            'lost': str(channel.n_lost),
            'duplicates': str(channel.n_duplicates),
            'reordered': str(channel.n_reordered),
        }
        for channel in channels
    ]


def _row(
    mode: Mode, true: TrueMode | None, widest_f: float, widest_d: float, *, known: bool
) -> ModeRow:
    note = HARMONIC if mode.harmonic else ''
    if known and true is None and not mode.harmonic:
        note = 'extra'
    if true is not None and true.from_window:
        note = 'one window'
    return ModeRow(
        label=str(mode.id) if mode.id else UNKNOWN,
        frequency=_measure(
            mode.frequency_hz,
            mode.frequency_std_hz,
            widest_f,
            true.frequency_hz if true else math.nan,
            true.frequency_error_sigma if true else math.nan,
        ),
        damping=_measure(
            math.nan if mode.harmonic else PERCENT * mode.damping_ratio,
            PERCENT * mode.damping_ratio_std,
            widest_d,
            PERCENT * true.damping_ratio if true else math.nan,
            true.damping_error_sigma if true else math.nan,
        ),
        mpc=fixed(mode.mpc, 3),
        mpd=fixed(math.degrees(mode.mpd), 1),
        mac=fixed(true.mac if true else math.nan, 3),
        note=note,
        scattered=mark(mode) == SCATTERED,
    )


def _measure(value: float, std: float, widest: float, true: float, error_sigma: float) -> Measure:
    relative = _relative(std, value)
    return Measure(
        value=value_text(value, std),
        std=deviation_text(value, std),
        bar=relative / widest if widest > 0.0 and math.isfinite(std) else math.nan,
        true=value_text(true, std),
        error_sigma=error_sigma,
        error=fixed(PERCENT * (value / true - 1.0), 2, sign=True) if true else UNKNOWN,
    )


def _missed(true: TrueMode) -> ModeRow:
    return ModeRow(
        label=UNKNOWN,
        frequency=Measure(UNKNOWN, UNKNOWN, math.nan, value_text(true.frequency_hz)),
        damping=Measure(UNKNOWN, UNKNOWN, math.nan, value_text(PERCENT * true.damping_ratio)),
        mpc=UNKNOWN,
        mpd=UNKNOWN,
        mac=UNKNOWN,
        note='missed',
    )


def _relative(std: float, value: float) -> float:
    return std / value if math.isfinite(std) and value > 0.0 else 0.0
