"""Merge set-ups of roving sensors."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from autonomous_modal_analysis.api.found_modes import FoundModes, Placed
from autonomous_modal_analysis.api.modal_result import ModalResult
from autonomous_modal_analysis.api.robot import Layout, read_layout
from autonomous_modal_analysis.identified.merging import merge_set_ups, SetUp
from autonomous_modal_analysis.identified.results import (
    Identification,
    identification_json,
    SetUps,
)
from autonomous_modal_analysis.read_results import kept_name, read_modes, results_file
from autonomous_modal_analysis.views.output import merged_words, write_merged
from modal_core.channel import SensorLayout
from modal_core.errors import RecordingError
from modal_core.mode import ModeSet


@dataclass(frozen=True, eq=False, repr=False)
class MergedResult(FoundModes):
    """Modes over the points of several set-ups, by frequency.

    Parameters
    ----------
    identification : Identification
        Modes over all points.
    set_ups : SetUps
        They come from, and who saw which mode.
    name : str
        Names of the set-ups.
    layout : SensorLayout or None
        Where the channels are.
    """

    identification: Identification
    set_ups: SetUps
    name: str
    layout: SensorLayout | None = None

    @property
    def modes(self) -> ModeSet:
        """Modes over all points; NaN at points that no set-up saw of a mode."""
        return self.identification.modes

    @property
    def harmonics(self) -> ModeSet:
        """None: lines are of single recordings."""
        return self.identification.harmonics

    def headline(self) -> str:
        """Say what merging came to."""
        return '; '.join(merged_words(self.modes, self.set_ups))

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama merge --json`` prints."""
        return identification_json(self.identification)

    def save(self, folder: str | Path) -> None:
        """Write modes.json and report.html into a folder, as ``ama merge --out``.

        Parameters
        ----------
        folder : path
            Made when missing.

        Raises
        ------
        OSError
            It cannot be written to.
        """
        write_merged(Path(folder), self.identification, self.set_ups.names)

    def _placed(self) -> Placed | None:
        from autonomous_modal_analysis.api.placed_shapes import placed_shapes

        return placed_shapes(self.layout, self.modes)


def merge(
    results: Sequence[ModalResult | str | Path], *, layout: Layout | None = None
) -> MergedResult:
    """Merge the modes of several set-ups into modes over all points.

    Sensors that stay in place have the same channel names in all set-ups, the others their own.
    A mode that some set-ups missed stays; it is read out of their samples at its pole where they
    tell of it.

    Parameters
    ----------
    results : sequence of ModalResult or path
        Of :func:`autonomous_modal_analysis.identify` or ``Recording.identify``, or what they
        saved (modes.json or its folder).
    layout : SensorLayout, mapping, path or None
        Places and directions of all channels, for drawing the shapes.

    Returns
    -------
    MergedResult

    Raises
    ------
    ModalAnalysisError
        There are fewer than two, or they share no channel.

    Examples
    --------
    A frame of three floors with two sensors, one of which stays on the roof:

    >>> import numpy as np
    >>> from scipy.signal import lfilter
    >>> import autonomous_modal_analysis as ama
    >>> rng = np.random.default_rng(1)
    >>> pole = np.exp(2 * np.pi * 8 * (-0.01 + 1j) / 100)
    >>> def moved(shape):
    ...     force = rng.normal(size=30_000)
    ...     motion = lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], force)
    ...     return np.outer(motion, shape) + 0.1 * rng.normal(size=(30_000, 2))
    >>> first = ama.identify(moved([1.0, 0.4]), 100, channel_names=['roof', 'ground'])
    >>> second = ama.identify(moved([1.0, 0.8]), 100, channel_names=['roof', 'middle'])
    >>> merged = ama.merge([first, second])
    >>> merged.channel_names
    ('roof', 'ground', 'middle')
    >>> merged.shapes.real.round(1).ravel()
    array([1. , 0.4, 0.8])
    """
    sensors = read_layout(layout)
    found, set_ups = merge_set_ups([_set_up(each) for each in results], sensors)
    return MergedResult(found, set_ups, ', '.join(set_ups.names), sensors)


def _set_up(given: ModalResult | str | Path) -> SetUp:
    if isinstance(given, ModalResult):
        return SetUp(given.name, given.modes, given.found.parts, given.remarks)
    kept = results_file(Path(given))
    if kept is None:
        raise RecordingError(
            'not the results of an identification',
            where=given,
            expected='a result, or modes.json',
            advice='ama.open(...).identify() first',
        )
    return SetUp(kept_name(Path(given)), read_modes(kept))
