"""What an identification found: numbers with standard deviations, tables, files, pictures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api import modal_plots
from autonomous_modal_analysis.api.found_modes import FoundModes, Placed
from autonomous_modal_analysis.identified.identification import IdentifiedRecording
from autonomous_modal_analysis.identified.joint_sliding import JointSliding
from autonomous_modal_analysis.identified.results import identification_json, IdentifiedWindow
from autonomous_modal_analysis.report.words import band_words
from autonomous_modal_analysis.views.output import save_results
from modal_core.channel import SensorLayout
from modal_core.mode import ModeSet
from modal_reports import count

if TYPE_CHECKING:
    from modal_dashboard.arm_drawing import ArmDrawing
    from modal_recordings.open_recording import Recording
    from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class ModalResult(FoundModes):
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
    source : Recording or None
        Carries or names the robot to draw on, where no model is given.
    """

    found: IdentifiedRecording
    name: str
    model: 'FlexibleJointModel | None' = None
    layout: SensorLayout | None = None
    source: 'Recording | None' = None

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
    def sliding(self) -> JointSliding | None:
        """What part of the time the axes slid; None without joint states or their robot."""
        return self.found.identification.sliding

    def headline(self) -> str:
        """Say how many modes were found, where, or why none was."""
        identification = self.found.identification
        reason = identification.quality.reason or 'nothing stands out of the noise'
        text = f'{count(len(self), "mode")} of {self.name} by {self.modes.method}'
        text += '' if len(self) else f': {reason}'
        if identification.band is not None:
            text += f'; {band_words(identification.band)}'
        text += f'; damaged: {"; ".join(self.damage)}' if self.damage else ''
        text = '\nnote: '.join((text, *self.remarks))
        return text if self.sliding is None else f'{text}\n{self.sliding.words()}'

    def choose(self, poles: str | Path) -> 'ModalResult':
        """Return the modes that a person picked in the report, as ``ama identify --poles``.

        Parameters
        ----------
        poles : path
            The file that the stabilisation diagram saved.

        Raises
        ------
        ModalAnalysisError
            It cannot be read, or its poles are of other data or other settings.
        """
        from autonomous_modal_analysis.identified.chosen_poles import read_poles, with_poles

        chosen = read_poles(Path(poles))
        return replace(self, found=with_poles(self.found, chosen, poles))

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
        save_results(Path(folder), self.found, self.name, placed=self._placed())

    def _placed(self) -> Placed | None:
        from autonomous_modal_analysis.api.placed_shapes import placed_shapes
        from autonomous_modal_analysis.api.recorded_places import recorded_places

        drawing = self.drawing()
        if drawing is not None:
            return drawing.placed
        path = None if self.source is None else Path(self.source.path)
        return placed_shapes(self.layout, self.modes, (), self._others) or recorded_places(
            path, self.modes
        )

    @property
    def _others(self) -> frozenset[str]:
        channels = self.found.identification.channels
        return frozenset(channel.name for channel in channels if not channel.is_straight)

    def drawing(self, modes: ModeSet | None = None) -> 'ArmDrawing | None':
        """Return modes on the arm of this recording.

        Parameters
        ----------
        modes : ModeSet or None
            Of the same channels; None: those that were found here.

        Returns
        -------
        ArmDrawing or None
            None without a robot, or where its pose is not known.
        """
        model, layout = self.model, self.layout
        if model is None and self.source is not None:
            from autonomous_modal_analysis.identified.known_robot import layout_of, robot_of

            model = robot_of(self.source)
            if model is not None and layout is None:
                layout = layout_of(self.source, model.robot_name, self.modes.channel_names)
        if model is None or layout is None:
            return None
        from autonomous_modal_analysis.views.arm_drawing import draw_identified

        return draw_identified(model, layout, self.found.identification, modes)

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

        own = not lines or self.drawing() is not None
        placed = (
            self._placed() if own else placed_shapes(self.layout, self.modes, lines, self._others)
        )
        if placed is not None:
            return modal_plots.plot_on_geometry(self.modes, *placed)
        return modal_plots.plot_bars(self.modes)
