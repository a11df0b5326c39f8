"""A mode with cubic stiffness and cubic damping: its responses of higher order.

q̈ + c₁ q̇ + c₃ q̇³ + k₁ q + k₃ q³ = force over modal mass, q the displacement at one channel.

References
----------
Worden and Tomlinson (2001), Nonlinearity in Structural Dynamics, doi:10.1201/9780429138331
(harmonic balance, harmonic probing); Caughey (1963), doi:10.1121/1.1918794 (Gaussian responses).
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class CubicMode:
    """A mode of modal mass one, at one channel.

    Parameters
    ----------
    frequency_hz : float [Hz]
    damping_ratio : float
        Both where it hardly moves.
    cubic_stiffness : float [1/(m² s²)]
        k₃.
    cubic_damping : float [s/m²]
        c₃.
    """

    frequency_hz: float
    damping_ratio: float
    cubic_stiffness: float = 0.0
    cubic_damping: float = 0.0

    @property
    def stiffness(self) -> float:
        """k₁ [1/s²]."""
        return (2.0 * math.pi * self.frequency_hz) ** 2

    @property
    def damping(self) -> float:
        """c₁ [1/s]."""
        return 4.0 * math.pi * self.damping_ratio * self.frequency_hz

    def first_order(self, omega: NDArray[np.float64] | float) -> NDArray[np.complex128]:
        """Return H₁ [s²], displacement over force per modal mass, at angular frequencies."""
        s = 1j * np.asarray(omega)
        return np.asarray(1.0 / (s**2 + self.damping * s + self.stiffness))

    def third_order(self, a: float, b: float, c: float) -> complex:
        """Return H₃(a, b, c), what three angular frequencies give at their sum."""
        law = self.cubic_stiffness + self.cubic_damping * (1j * a) * (1j * b) * (1j * c)
        linear = np.prod(self.first_order(np.array([a, b, c, a + b + c])))
        return complex(-law * linear)

    def harmonics(self, force: float, hz: float) -> tuple[complex, complex]:
        """Return the response to a sine at its frequency and at three times that, to third order.

        Holds while 3/4 k₃ |q|² is small against 2 ζ k₁ (see :meth:`converges`).

        Parameters
        ----------
        force : float [N/kg]
            Amplitude over modal mass.
        hz : float [Hz]
            Of the sine.
        """
        omega = 2.0 * math.pi * hz
        own = force * complex(self.first_order(omega))
        own += 0.75 * force**3 * self.third_order(omega, omega, -omega)
        return own, 0.25 * force**3 * self.third_order(omega, omega, omega)

    def converges(self, displacement_m: float) -> float:
        """Return 3/4 |k₃| q² over 2 ζ k₁: well below 1 where a series of third order holds."""
        return (
            0.75
            * abs(self.cubic_stiffness)
            * displacement_m**2
            / (2.0 * self.damping_ratio * self.stiffness)
        )

    def at_sine(self, displacement_m: float) -> tuple[float, float]:
        """Return frequency [Hz] and damping ratio at an amplitude of a sine (harmonic balance)."""
        return self._equivalent(0.75 * displacement_m**2)

    def at_random(self, displacement_rms_m: float) -> tuple[float, float]:
        """Return frequency [Hz] and damping ratio of a Gaussian response (Caughey 1963)."""
        return self._equivalent(3.0 * displacement_rms_m**2)

    def _equivalent(self, square: float) -> tuple[float, float]:
        stiffness = self.stiffness + self.cubic_stiffness * square
        if stiffness <= 0.0:
            return math.nan, math.nan
        omega = math.sqrt(stiffness)
        damping = self.damping + self.cubic_damping * square * omega**2
        return omega / (2.0 * math.pi), damping / (2.0 * omega)
