"""Two results over each other: spectra, modes, shapes."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.report.still_pictures import placed
from modal_core.mode import Mode, ModeSet
from modal_reports import (
    compared_spectra_data,
    ComparedSpectrum,
    damping_plane,
    mode_shapes_data,
    OtherShape,
    Spectrum,
)
from oma_identifier.compare import ModeComparison

if TYPE_CHECKING:
    from modal_dashboard.arm_drawing import ArmDrawing

Shape = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class StateDrawn:
    """What beside its modes can be drawn of a result.

    Parameters
    ----------
    spectrum : Spectrum or None
        Of the recording.
    drawing : ArmDrawing or None
        Its modes on the arm, in the pose of the first recording.
    """

    spectrum: Spectrum | None = None
    drawing: 'ArmDrawing | None' = None


State = tuple[str, ModeSet, StateDrawn]


def spectra_of_both(first: State, second: State) -> dict[str, object] | None:
    """Return the chart of two spectra; None where neither is known."""
    return compared_spectra_data(
        [ComparedSpectrum(name, modes, drawn.spectrum) for name, modes, drawn in (first, second)]
    )


def damping_of_both(first: ModeSet, second: ModeSet) -> Markup:
    """Return damping over natural frequency of both, with ellipses of ±2 σ."""
    modes = [replace(placed(mode), kind='before') for mode in first]
    modes += [replace(placed(mode), kind='after') for mode in second]
    return damping_plane('Damping over frequency of both', modes) if modes else Markup()


def shapes_of_both(
    found: ModeComparison, modes: ModeSet, others: ModeSet, drawn: StateDrawn, other: StateDrawn
) -> dict[str, object]:
    """Return the pictures of the pairs' shapes, the second scaled to the first.

    Parameters
    ----------
    found : ModeComparison
        The pairs.
    modes, others : ModeSet
        Of both, in the order of their drawings.
    drawn, other : StateDrawn
        On one arm where it is known.
    """
    arm = drawn.drawing if other.drawing is not None else None
    pairs = [(_place(c.first, modes), _place(c.second, others)) for c in found.changes]
    firsts = ModeSet(tuple(modes.modes[row] for row, _ in pairs), modes.channel_names)
    moved = [arm.displacements[row] for row, _ in pairs] if arm is not None else []
    shapes = []
    for index, (row, column) in enumerate(pairs):
        mode = others.modes[column]
        seen = _on_channels(mode.shape, others.channel_names, modes.channel_names)
        fitted = replace(mode, shape=_fitted(seen, modes.modes[row].shape))
        on_arm = None
        if arm is not None and other.drawing is not None:
            on_arm = _fitted(np.asarray(other.drawing.displacements[column]), moved[index])
        shapes.append(OtherShape(fitted, on_arm))
    geometry = arm.geometry if arm is not None else None
    return mode_shapes_data(firsts, geometry, moved, shapes)


def _place(mode: Mode, modes: ModeSet) -> int:
    return next(row for row, each in enumerate(modes) if each is mode)


def _on_channels(shape: Shape, own: tuple[str, ...], wanted: tuple[str, ...]) -> Shape:
    """Return a shape at other channels; NaN where it has none."""
    seen = np.full(len(wanted), np.nan, dtype=complex)
    for row, name in enumerate(wanted):
        if name in own:
            seen[row] = shape[own.index(name)]
    return seen


def _fitted(shape: Shape, to: Shape) -> Shape:
    """Return a shape times the complex number that brings it nearest to another one."""
    both = np.isfinite(shape) & np.isfinite(to)
    size = float(np.sum(np.abs(shape[both]) ** 2))
    factor = np.vdot(shape[both], to[both]) / size if size > 0.0 else 1.0
    return np.asarray(factor * shape)
