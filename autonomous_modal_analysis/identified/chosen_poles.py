"""Modes that a person chose from the stabilisation diagram, in place of the automatic choice."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from autonomous_modal_analysis.identified.identification import IdentifiedRecording
from modal_core.errors import SettingsError
from modal_core.files.json_file import load_json
from modal_core.mode import Mode
from modal_core.numbers.indicators import mpc, mpd, normalise
from modal_core.poles import PoleTable

FORMAT = 'poles-1'
LARGEST_BYTES = 1_000_000
SAME = 1e-4
"""Share of a frequency, and of critical damping, within which a pole is the one that was picked:
the report has six digits, and what another setting finds differs by more."""


@dataclass(frozen=True, slots=True)
class ChosenPole:
    """A pole that was picked.

    Parameters
    ----------
    model_order : int
        Order it was found at.
    frequency_hz, damping_ratio : float [Hz], [-]
        To know it again.
    """

    model_order: int
    frequency_hz: float
    damping_ratio: float

    def words(self) -> str:
        """Say which it is."""
        return f'order {self.model_order}, {self.frequency_hz:.6g} Hz'


def read_poles(path: str | Path) -> tuple[ChosenPole, ...]:
    """Read the file that a report saved.

    Raises
    ------
    SettingsError
        It cannot be read, or is no such file.
    """
    path = Path(path)
    data = load_json(path, LARGEST_BYTES)
    try:
        if data['format'] != FORMAT:
            raise ValueError(f'format {data["format"]!r}')
        return tuple(_pole(entry) for entry in data['poles'])
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise SettingsError(
            'no file of picked poles',
            where=path,
            found=error,
            expected=f'format {FORMAT}, as the stabilisation diagram of a report saves it',
        ) from error


def _pole(entry: Mapping[str, float]) -> ChosenPole:
    found = ChosenPole(
        int(entry['model_order']), float(entry['frequency_hz']), float(entry['damping_ratio'])
    )
    if not (found.frequency_hz > 0.0 and np.isfinite([found.damping_ratio]).all()):
        raise ValueError(f'no pole: {entry}')
    return found


def with_poles(
    found: IdentifiedRecording, chosen: Sequence[ChosenPole], where: object = ''
) -> IdentifiedRecording:
    """Return a recording's modes as they were chosen; its windows stay as they are.

    A pole that belongs to a mode stands for that mode, refined and with its σ.  Another one is a
    mode of its own numbers, without σ.

    Parameters
    ----------
    found : IdentifiedRecording
        With all its poles.
    chosen : sequence of ChosenPole
        In any order.
    where : object
        Names the choice in errors.

    Raises
    ------
    SettingsError
        A pole is not there: other data, or other settings.
    """
    poles, identification = found.whole.poles, found.identification
    rows = [_row(poles, pole, where) for pole in chosen]
    automatic = {mode.id: mode for mode in identification.modes}
    ids = dict.fromkeys(int(poles.mode_id[row]) for row in rows)
    kept = [automatic[number] for number in ids if number in automatic]
    others = dict.fromkeys(row for row in rows if int(poles.mode_id[row]) not in automatic)
    first = max(automatic, default=0) + 1
    by_hand = [_mode(poles, row, first + place) for place, row in enumerate(others)]
    modes = tuple(sorted([*kept, *by_hand], key=lambda mode: mode.frequency_hz))
    said = (
        f'modes were chosen by hand: {len(kept)} of the {len(automatic)} automatic ones,'
        f' {len(by_hand)} single poles without σ'
    )
    changed = replace(
        identification,
        modes=replace(identification.modes, modes=modes),
        remarks=(*identification.remarks, said),
    )
    return replace(found, identification=changed)


def _row(poles: PoleTable, pole: ChosenPole, where: object) -> int:
    """Return the row of a pole."""
    away = np.maximum(
        np.abs(poles.frequency_hz / pole.frequency_hz - 1.0),
        np.abs(poles.damping_ratio - pole.damping_ratio),
    )
    away[poles.model_order != pole.model_order] = np.inf
    nearest = int(np.argmin(away)) if len(poles) else -1
    if nearest < 0 or away[nearest] > SAME:
        near = poles.frequency_hz[poles.model_order == pole.model_order]
        there = sorted(near, key=lambda hz: abs(hz - pole.frequency_hz))[:2]
        raise SettingsError(
            'no such pole in this recording',
            where=where,
            found=pole.words(),
            expected=', '.join(f'{hz:.6g} Hz' for hz in there) or 'an order that was looked at',
            advice='identify the recording of the report, with its settings',
        )
    return nearest


def _mode(poles: PoleTable, row: int, number: int) -> Mode:
    """Return a mode of a pole's own numbers."""
    shape = normalise(poles.shape[:, row])
    return Mode(
        frequency_hz=float(poles.frequency_hz[row]),
        damping_ratio=float(poles.damping_ratio[row]),
        shape=shape,
        mpc=float(np.squeeze(mpc(shape))),
        mpd=float(np.squeeze(mpd(shape))),
        id=number,
    )
