"""Whether the arm answers in proportion: measured over predicted, loud against quiet."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from model_gap.comparison.spectra_pairs import SpectraPair, used_bands
from model_gap.comparison.transmissibility import Ratio, ratio


@dataclass(frozen=True)
class LevelChange:
    """How the response per motion changes from the quiet to the loud level, in one band.

    Parameters
    ----------
    low_hz, high_hz : float [Hz]
        The band.
    quiet, loud : str
        The levels.
    factor, factor_sigma : float
        Loud over quiet of measured over predicted: 1 for an arm in proportion.
    phase_rad, phase_sigma_rad : float [rad]
        Its phase.
    coherence_quiet, coherence_loud : float
        With the prediction.
    """

    low_hz: float
    high_hz: float
    quiet: str
    loud: str
    factor: float
    factor_sigma: float
    phase_rad: float
    phase_sigma_rad: float
    coherence_quiet: float
    coherence_loud: float

    @property
    def deviations(self) -> float:
        """How many standard deviations it is away from proportion."""
        size = (self.factor - 1.0) / max(self.factor_sigma, 1e-12)
        turn = self.phase_rad / max(self.phase_sigma_rad, 1e-12)
        return math.hypot(size, turn) / math.sqrt(2.0)


def level_changes(pairs: Sequence[SpectraPair]) -> tuple[LevelChange, ...]:
    """Compare the loudest with the quietest level at the poses that have both, band by band."""
    sizes: dict[str, list[float]] = {}
    for pair in pairs:
        size = float(np.sqrt(np.mean(pair.item.record.motor_acceleration**2)))
        sizes.setdefault(pair.item.record.level, []).append(size)
    if len(sizes) < 2:
        return ()
    order = sorted(sizes, key=lambda level: float(np.mean(sizes[level])))
    quiet, loud = order[0], order[-1]
    found = []
    for low, high in used_bands(pairs):
        one, two = _band(pairs, quiet, low, high), _band(pairs, loud, low, high)
        if one is None or two is None or not one.magnitude:
            continue
        relative = math.hypot(
            one.magnitude_sigma / one.magnitude, two.magnitude_sigma / max(two.magnitude, 1e-12)
        )
        factor = two.magnitude / one.magnitude
        found.append(
            LevelChange(
                low_hz=low,
                high_hz=high,
                quiet=quiet,
                loud=loud,
                factor=factor,
                factor_sigma=factor * relative,
                phase_rad=math.remainder(two.phase_rad - one.phase_rad, 2.0 * math.pi),
                phase_sigma_rad=math.hypot(one.phase_sigma_rad, two.phase_sigma_rad),
                coherence_quiet=one.coherence,
                coherence_loud=two.coherence,
            )
        )
    return tuple(found)


def _band(pairs: Sequence[SpectraPair], level: str, low: float, high: float) -> Ratio | None:
    """Compare with the model as it is now, whitened, over all recordings of a level."""
    measured, predicted = [], []
    for pair in pairs:
        if pair.item.record.level == level:
            inside = pair.inside(low, high)
            data = pair.item.seen & inside
            measured.append(pair.item.over_noise(pair.item.measured)[data])
            predicted.append(pair.item.over_noise(pair.after)[data])
    if not measured:
        return None
    one, two = np.concatenate(measured), np.concatenate(predicted)
    return ratio(one, two, float(len(two)))
