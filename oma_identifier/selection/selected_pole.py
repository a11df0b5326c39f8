"""A candidate for a mode: the mean of a cluster of poles, and how well the data determine it."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.numbers.indicators import mpc
from oma_identifier.likelihood import least_blur, least_scatter
from oma_identifier.selection.cluster import Cluster
from oma_identifier.selection.identified_band import IdentifiedBand
from oma_identifier.selection.line_decision import line_reach
from oma_identifier.selection.thresholds import SELECTION
from oma_identifier.subspace import PoleDeviation


@dataclass(frozen=True, slots=True, eq=False)
class SelectedPole:
    """One mode candidate.

    Parameters
    ----------
    band : IdentifiedBand
        Where it was found.
    cluster : Cluster
        Poles it is the mean of.
    pole : complex [rad/s]
        Continuous time.
    shape : (n_channels,) complex array
        Mode shape over channels divided by their root mean square in the band.
    deviation : PoleDeviation
        Standard deviations of the mean.
    blur : float
        Standard deviation of the most precise member in half-power half-widths, root mean square
        of frequency and damping.
    """

    band: IdentifiedBand
    cluster: Cluster
    pole: complex
    shape: NDArray[np.complex128]
    deviation: PoleDeviation
    blur: float

    @property
    def frequency_hz(self) -> float:
        """Natural frequency [Hz]."""
        return abs(self.pole) / (2.0 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """Damping ratio."""
        return -self.pole.real / abs(self.pole)

    @property
    def half_width_hz(self) -> float:
        """Half-power half-width [Hz]."""
        return self.damping_ratio * self.frequency_hz

    @property
    def physical_shape(self) -> NDArray[np.complex128]:
        """Mode shape in units of the channels."""
        return np.asarray(self.shape * self.band.scale)

    @property
    def has_complex_shape(self) -> bool:
        """Whether the phases are nearer to a circle than to a line."""
        return len(self.shape) > 1 and bool(mpc(self.shape[:, None])[0] < SELECTION.least_mpc)

    @property
    def is_determined(self) -> bool:
        """Whether the data determine the mean pole; False when a deviation is NaN."""
        most_blur = max(SELECTION.widest_mean, SELECTION.doubtful * least_blur(self._cycles))
        widest = most_blur * self.damping_ratio
        return (
            self.deviation.frequency_std_hz < widest * self.frequency_hz
            and self.deviation.damping_ratio_std < widest
        )

    @property
    def is_unresolved(self) -> bool:
        """Whether the record is too short to see its bell, and to tell its damping."""
        return self._cycles < SELECTION.least_cycles

    @property
    def freed_damping_ratio(self) -> float:
        """Damping ratio less what a record of finite length adds to it."""
        if not self.band.is_blind:
            return self.damping_ratio
        added = SELECTION.damping_bias / (self.band.duration_s * abs(self.pole))
        return max(self.damping_ratio - added, SELECTION.least_left * self.damping_ratio)

    @property
    def frequency_std_hz(self) -> float:
        """Standard deviation of the natural frequency [Hz]."""
        scatter = math.hypot(self.deviation.frequency_std_hz, self._order_bias * self.frequency_hz)
        return max(scatter, self._least_scatter * self.frequency_hz)

    @property
    def line_reach(self) -> float:
        """Relative distance within which it may be the image of a line."""
        return line_reach(self.frequency_hz, self.band.duration_s, SELECTION.sharp)

    @property
    def damping_ratio_std(self) -> float:
        """Standard deviation of the damping ratio; NaN where the record is too short for it."""
        if self.is_unresolved:
            return math.nan
        scatter = math.hypot(self.deviation.damping_ratio_std, self._order_bias)
        return max(scatter, self._least_scatter)

    @property
    def _least_scatter(self) -> float:
        """Least deviation, of the frequency over itself and of the damping ratio."""
        if not self.band.is_blind:
            return 0.0
        periods = self.frequency_hz * self.band.duration_s
        return least_scatter(self.freed_damping_ratio, periods)

    @property
    def _order_bias(self) -> float:
        """Deviation by the model order, of the frequency over itself and of the damping ratio."""
        return SELECTION.order_bias * self.damping_ratio * self.band.is_blind

    @property
    def is_too_certain(self) -> bool:
        """Whether it scatters less than the response to any random force allows."""
        return self.band.is_blind and self.from_limit < SELECTION.too_certain

    @property
    def from_limit(self) -> float:
        """The blur in multiples of the least that any method can reach."""
        return self.blur / least_blur(self._cycles)

    @property
    def _cycles(self) -> float:
        return self.damping_ratio * self.frequency_hz * self.band.duration_s
