"""Modes beside the true ones where they are known, as texts."""

from dataclasses import dataclass, replace
import math

from autonomous_modal_analysis.report.content import ReportContent
from autonomous_modal_analysis.report.truth import TrueMode
from modal_core.mode import Mode
from modal_reports import (
    DAMPING,
    fixed,
    FREQUENCY,
    HARMONIC,
    KNOWN,
    mark,
    Quantity,
    SCATTERED,
    UNKNOWN,
)

MISSED = 'missed'


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
        How many set-ups saw it where several were merged; ``harmonic``, ``missed``, ``extra`` (no
        true mode belongs to it), ``one window`` (the whole recording does not show it) or nothing.
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
    driven: bool = False


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
    if (set_ups := content.identification.set_ups) is not None:
        rows = [
            (at_hz, replace(row, note=set_ups.words(index)))
            for index, (at_hz, row) in enumerate(rows)
        ]
    rows += [(true.frequency_hz, _missed(true)) for true in truth if true.mode is None]
    return [row for _, row in sorted(rows, key=lambda pair: pair[0])]


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
            FREQUENCY,
            mode.frequency_hz,
            mode.frequency_std_hz,
            widest_f,
            true.frequency_hz if true else math.nan,
            true.frequency_error_sigma if true else math.nan,
        ),
        damping=_measure(
            DAMPING,
            math.nan if mode.harmonic else mode.damping_ratio,
            mode.damping_ratio_std,
            widest_d,
            true.damping_ratio if true else math.nan,
            true.damping_error_sigma if true else math.nan,
        ),
        mpc=fixed(mode.mpc, 3),
        mpd=fixed(math.degrees(mode.mpd), 1),
        mac=fixed(true.mac if true else math.nan, 3),
        note=note,
        scattered=SCATTERED in mark(mode),
        driven=KNOWN in mark(mode),
    )


def _measure(
    quantity: Quantity, value: float, std: float, widest: float, true: float, error_sigma: float
) -> Measure:
    relative = _relative(std, value)
    shown, deviation = quantity.pair(value, std)
    return Measure(
        value=shown,
        std=deviation,
        bar=relative / widest if widest > 0.0 and math.isfinite(std) else math.nan,
        true=quantity.pair(true, std)[0],
        error_sigma=error_sigma,
        error=fixed(100.0 * (value / true - 1.0), 2, sign=True) if true else UNKNOWN,
    )


def _missed(true: TrueMode) -> ModeRow:
    return ModeRow(
        label=UNKNOWN,
        frequency=Measure(UNKNOWN, UNKNOWN, math.nan, FREQUENCY.number(true.frequency_hz)),
        damping=Measure(UNKNOWN, UNKNOWN, math.nan, DAMPING.number(true.damping_ratio)),
        mpc=UNKNOWN,
        mpd=UNKNOWN,
        mac=UNKNOWN,
        note=MISSED,
    )


def _relative(std: float, value: float) -> float:
    return std / value if math.isfinite(std) and value > 0.0 else 0.0
