"""The sensors' clock runs away from that of the joint states."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, Filter
from model_gap.effects.effect import Effect, EffectParameter, Scene

# Of a Taylor series over half a sample: at Nyquist the next is (π/2)⁸/8!, 0.1 % of the motion.
ORDERS = 8


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
    """Return a step that reads series at (1 + rate) times their time."""

    def step(omega: NDArray[np.float64], spectra: Complex) -> Complex:
        size = 2 * (len(omega) - 1)
        period_s = 2.0 * np.pi / omega[1] / size
        wanted = (1.0 + rate) * np.arange(size)
        nearest = np.rint(wanted)
        beyond_s, places = period_s * (wanted - nearest), nearest.astype(int) % size
        found, weight, derivative = np.zeros((len(spectra), size)), np.ones(size), spectra
        for order in range(1, ORDERS + 1):
            found += weight * np.fft.irfft(derivative, size)[:, places]
            weight, derivative = weight * beyond_s / order, 1j * omega * derivative
        return np.asarray(np.fft.rfft(found))

    return step
