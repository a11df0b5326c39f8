"""The sensors' clock runs away from that of the joint states."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, Filter
from model_gap.effects.effect import Effect, EffectParameter, Scene


class ClockDrift(Effect):
    """u(t) → u((1 + ρ) t), t since the recording began.

    Frequencies that sensors show change by ρ too.  That is left out: it is what stiffness off by
    2ρ does, far within any tolerance (1.2 % of the response of an arm with ρ = 3e-4, 0.4 % with
    1e-4, no tolerance fitted).
    """

    type = 'clock_drift'
    equation = 'u(t) -> u((1 + ρ) t), t since each recording began'
    source = 'Sivrikaya and Yener (2004), doi:10.1109/MNET.2004.1316761, clocks of constant rate'
    signature = 'the phase of every sensor falls, or rises, all through a recording'
    moves_poles = False
    confused_with: ClassVar[Mapping[str, str]] = {
        'command_delay': 'a recording several times as long: a drift grows with it, a delay not'
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one."""
        return [cls(None)]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return by what share of it the joint states' time runs faster."""
        return (EffectParameter('rate', '1', 1e-4, -1e-3, 1e-3),)

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return how fast or slow."""
        rate = numbers['rate']
        way = 'loses' if rate > 0.0 else 'gains'
        return (
            f"The sensors' clock {way} {1e6 * abs(rate):.3g} µs a second "
            'on that of the joint states'
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Let the motors move as the sensors' clock sees it."""
        return cell.then_input(_stretching(values[0]))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return what crystals are off by, and more."""
        return [(sign * rate,) for rate in (3e-5, 1.5e-4, 5e-4) for sign in (-1.0, 1.0)]


def _stretching(rate: float) -> Filter:
    """Return a step that reads series at (1 + rate) times their time, as a chirp transform does.

    References
    ----------
    Rabiner, Schafer and Rader (1969), doi:10.1109/TAU.1969.1162034.
    """

    def step(omega: NDArray[np.float64], spectra: Complex) -> Complex:
        from scipy.signal import czt  # half a second to load

        size = 2 * (len(omega) - 1)
        share = np.full(len(omega), 2.0 / size)
        share[[0, -1]] = 1.0 / size
        turn = np.exp(2j * np.pi * (1.0 + rate) / size)
        return np.asarray(np.fft.rfft(czt(spectra * share, size, turn).real))

    return step
