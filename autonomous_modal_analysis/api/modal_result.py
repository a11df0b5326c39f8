"""What an identification found: numbers with standard deviations, tables, files, pictures."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api import modal_plots
from autonomous_modal_analysis.api.result import Columns, Result
from autonomous_modal_analysis.identification import IdentifiedRecording
from autonomous_modal_analysis.output import save_results
from autonomous_modal_analysis.report.words import band_words
from autonomous_modal_analysis.results import identification_json, IdentifiedWindow
from modal_core.channel import SensorLayout
from modal_core.mode import Mode, MODE_FIELDS, ModeSet
from modal_reports import count, DAMPING, fixed, FREQUENCY, mark, MPC

if TYPE_CHECKING:
    from autonomous_modal_analysis.arm_drawing import ArmDrawing
    from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class ModalResult(Result):
    """Modes of an array or a recording, by frequency.

    Parameters
    ----------
    found : IdentifiedRecording
        Modes of the whole and of its windows, with poles and spectrum.
    name : str
        Where they come from.
    model : FlexibleJointModel or None
        Robot the shapes are drawn on.
    layout : SensorLayout or None
        Where the channels are.
    """

    found: IdentifiedRecording
    name: str
    model: 'FlexibleJointModel | None' = None
    layout: SensorLayout | None = None

    @property
    def modes(self) -> ModeSet:
        """Modes of the whole recording."""
        return self.found.identification.modes

    @property
    def harmonics(self) -> ModeSet:
        """Lines of machines and drives, kept out of the modes."""
        return self.found.identification.harmonics

    @property
    def windows(self) -> tuple[IdentifiedWindow, ...]:
        """Modes of each window, by time; the ids of modes last over the windows."""
        return self.found.identification.windows

    @property
    def damage(self) -> tuple[str, ...]:
        """What could not be read or was not used, one statement each; empty for sound data."""
        return self.found.identification.damage

    @property
    def remarks(self) -> tuple[str, ...]:
        """What should be known, one statement with its remedy each; empty when all fits."""
        return self.found.identification.remarks

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Rows of ``shapes``."""
        return self.modes.channel_names

    @property
    def frequencies_hz(self) -> Array:
        """Natural frequencies, (n_modes,) [Hz]."""
        return self.modes.frequency_hz

    @property
    def frequencies_std_hz(self) -> Array:
        """Standard deviations of the natural frequencies, (n_modes,) [Hz]; NaN: not known."""
        return self._each(lambda mode: mode.frequency_std_hz)

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios as fractions of critical damping, (n_modes,)."""
        return self.modes.damping_ratio

    @property
    def damping_ratios_std(self) -> Array:
        """Standard deviations of the damping ratios, (n_modes,); NaN: not known."""
        return self._each(lambda mode: mode.damping_ratio_std)

    @property
    def shapes(self) -> NDArray[np.complex128]:
        """Mode shapes as columns, (n_channels, n_modes), the largest entry of each 1 + 0i."""
        return self.modes.shapes

    @property
    def shapes_std(self) -> NDArray[np.complex128]:
        """Standard deviations of the real parts + i · those of the imaginary parts of ``shapes``.

        (n_channels, n_modes); NaN: not known.
        """
        unknown = np.full(len(self.channel_names), complex(np.nan, np.nan))
        columns = [unknown if mode.shape_std is None else mode.shape_std for mode in self.modes]
        return np.reshape(columns, (len(columns), len(unknown))).T.astype(complex)

    def _each(self, number: Callable[[Mode], float]) -> Array:
        return np.array([number(mode) for mode in self.modes], dtype=float)

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.modes)

    def headline(self) -> str:
        """Say how many modes were found, where, or why none was."""
        identification = self.found.identification
        reason = identification.quality.reason or 'nothing stands out of the noise'
        text = f'{count(len(self), "mode")} of {self.name} by {self.modes.method}'
        text += '' if len(self) else f': {reason}'
        if identification.band is not None:
            text += f'; {band_words(identification.band)}'
        text += f'; damaged: {"; ".join(self.damage)}' if self.damage else ''
        return '\nnote: '.join((text, *self.remarks))

    def columns(self) -> Columns:
        """Return modes and harmonic lines by column; σ is NaN where it is not known."""
        modes = self._listed()
        return {
            **{
                item.column: [getattr(mode, item.name) for mode in modes]
                for item in MODE_FIELDS
                if item.single
            },
            **{
                f'shape.{name}': [complex(mode.shape[row]) for mode in modes]
                for row, name in enumerate(self.channel_names)
            },
        }

    def _listed(self) -> list[Mode]:
        return sorted((*self.modes, *self.harmonics), key=lambda mode: mode.frequency_hz)

    def shown(self) -> Columns:
        """Return modes and harmonic lines as texts."""
        modes = self._listed()
        marks = [mark(mode) for mode in modes]
        return {
            FREQUENCY.label: [FREQUENCY.number(m.frequency_hz, m.frequency_std_hz) for m in modes],
            DAMPING.label: [
                '' if mode.harmonic else DAMPING.number(mode.damping_ratio, mode.damping_ratio_std)
                for mode in modes
            ],
            MPC.label: [fixed(mode.mpc, 3) for mode in modes],
            **({'': marks} if any(marks) else {}),
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama identify --json`` prints."""
        return identification_json(self.found.identification)

    def save(self, folder: str | Path) -> None:
        """Write modes.json, modes.csv and report.html into a folder, as ``ama identify --out``.

        Parameters
        ----------
        folder : path
            Made when missing.

        Raises
        ------
        OSError
            It cannot be written to.
        """
        save_results(Path(folder), self.found, self.name, drawing=self._drawing())

    def _drawing(self) -> 'ArmDrawing | None':
        """Return the modes on the arm; None without a robot, or where its pose is not known."""
        if self.model is None or self.layout is None:
            return None
        from autonomous_modal_analysis.arm_drawing import draw_identified

        return draw_identified(self.model, self.layout, self.found.identification)

    def plot_spectrum(self, ax: Any = None) -> Any:
        """Draw the singular values of the cross-spectral density and the modes in it.

        Parameters
        ----------
        ax : matplotlib Axes or None
            Where to; None: a new figure.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        ModalAnalysisError
            matplotlib is not installed.
        """
        return modal_plots.plot_spectrum(self.found.whole, ax)

    def plot_stabilisation(self, ax: Any = None) -> Any:
        """Draw the stabilisation diagram: poles over model order, the spectrum behind them.

        Parameters, returns and raises as :meth:`plot_spectrum`.
        """
        return modal_plots.plot_stabilisation(self.found.whole, ax)

    plot_stabilization = plot_stabilisation

    def plot_tracks(self, ax: Any = None) -> Any:
        """Draw the natural frequency of every mode over the windows, with standard deviations.

        Parameters, returns and raises as :meth:`plot_spectrum`.
        """
        return modal_plots.plot_tracks(self.windows, ax)

    def plot_shapes(self, lines: Sequence[Sequence[str]] = ()) -> Any:
        """Draw the mode shapes: on the robot, at the places of the sensors, or as bars.

        Bars are the real parts with standard deviations, dots the imaginary parts.

        Parameters
        ----------
        lines : sequence of sequence of str
            Names of sensors to connect, in order, where the layout places them.

        Returns
        -------
        (n_modes,) array of matplotlib Axes
            In one figure.

        Raises
        ------
        ModalAnalysisError
            matplotlib is not installed, or a line names no sensor of the layout.
        """
        from autonomous_modal_analysis.api.placed_shapes import placed_shapes

        drawing = self._drawing()
        if drawing is not None:
            return modal_plots.plot_on_geometry(
                self.modes, drawing.geometry, drawing.displacements
            )
        placed = placed_shapes(self.layout, self.modes, lines)
        if placed is not None:
            return modal_plots.plot_on_geometry(self.modes, *placed)
        return modal_plots.plot_bars(self.modes)
