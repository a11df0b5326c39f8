"""Modes as numbers with standard deviations, tables and files, wherever they come from."""

from abc import abstractmethod
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api.result import Columns, Result
from modal_core.files.version import software
from modal_core.mode import Mode, MODE_FIELDS, ModeSet
from modal_reports import DAMPING, fixed, FREQUENCY, Geometry, mark, MPC

Array = NDArray[np.float64]
Placed = tuple[Geometry, tuple[NDArray[np.complex128], ...]]


class FoundModes(Result):
    """Modes by frequency."""

    name: str

    @property
    @abstractmethod
    def modes(self) -> ModeSet:
        """The modes."""

    @property
    @abstractmethod
    def harmonics(self) -> ModeSet:
        """Lines of machines and drives, kept out of the modes."""

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
        return self.modes.shapes_std

    def _each(self, number: Callable[[Mode], float]) -> Array:
        return np.array([number(mode) for mode in self.modes], dtype=float)

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.modes)

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

    def export(self, path: str | Path) -> None:
        """Write the modes into one file of another program, whole or not at all.

        Parameters
        ----------
        path : path
            Ends in .uff or .unv (datasets 15, 82, 55), .mat, .nc, .parquet or .csv.

        Raises
        ------
        ModalAnalysisError
            No such kind, or a library that it needs is not installed.
        OSError
            It cannot be written.
        """
        from autonomous_modal_analysis.export import export_modes, Exported

        about = {'recording': self.name, 'software': software()}
        geometry, moved = self._placed() or (None, ())
        exported = Exported(self.modes, self.harmonics, about, geometry, moved, self._others)
        export_modes(Path(path), exported)

    @property
    def _others(self) -> frozenset[str]:
        """Channels that measure no motion along a direction, where that is known."""
        return frozenset()

    @abstractmethod
    def _placed(self) -> Placed | None:
        """Return the points and how each mode moves them; None where nobody knows."""
