"""The model of the cell: the arm, its sensors, and what happens between them.

Effects and tolerances change a :class:`CellModel` and return a new one, so that any number of them
compose in any order.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from model_gap.laws import JointLaw
from structural_model import ModelSpec

Spectrum = NDArray[np.complex128]
# (omega (n_bins,), spectra (n_rows, n_bins)) -> (n_rows, n_bins)
Filter = Callable[[NDArray[np.float64], Spectrum], Spectrum]


@dataclass(frozen=True)
class JointForce:
    """A torque between motor and link of one joint that is not linear in the deflection.

    Parameters
    ----------
    joint : str
        Joint it acts in.
    law : type of JointLaw
        The torque as a function of twist, rate and motor speed.
    values : tuple of float
        Parameters of the law.
    """

    joint: str
    law: type[JointLaw]
    values: tuple[float, ...]


@dataclass(frozen=True)
class CellModel:
    """Arm, sensors, and what lies between motion and reading.

    Parameters
    ----------
    spec : ModelSpec
        The arm.
    channels : tuple of Channel
        The sensor axes.
    inputs, outputs : tuple of Filter
        Applied in order to the motor accelerations and to the readings.
    forces : tuple of JointForce
        Nonlinear torques.
    ripples, tones : tuple of Ripple, Tone
        Motions and forces that are there whatever the arm does.
    held : tuple of HeldTorque
        Nonlinear torques that were computed before and stay as they are.
    """

    spec: ModelSpec
    channels: tuple[Channel, ...]
    inputs: tuple[Filter, ...] = ()
    outputs: tuple[Filter, ...] = ()
    forces: tuple[JointForce, ...] = ()
    ripples: tuple['Ripple', ...] = ()
    tones: tuple['Tone', ...] = ()
    held: tuple['HeldTorque', ...] = ()

    def with_spec(self, spec: ModelSpec) -> 'CellModel':
        """Return a copy with another arm."""
        return replace(self, spec=spec)

    def then_output(self, step: Filter) -> 'CellModel':
        """Return a copy with one more step behind the sensors."""
        return replace(self, outputs=(*self.outputs, step))

    def driven(
        self, omega: NDArray[np.float64], acceleration: Spectrum, shift: Spectrum
    ) -> tuple[Spectrum, Spectrum]:
        """Return the motor motion behind the inputs' steps."""
        for step in self.inputs:
            acceleration, shift = step(omega, acceleration), step(omega, shift)
        return acceleration, shift

    def seen(self, omega: NDArray[np.float64], readings: Spectrum) -> Spectrum:
        """Return readings behind the outputs' steps."""
        for step in self.outputs:
            readings = step(omega, readings)
        return readings

    def then_input(self, step: Filter) -> 'CellModel':
        """Return a copy with one more step before the motors."""
        return replace(self, inputs=(*self.inputs, step))


@dataclass(frozen=True, eq=False)
class HeldTorque:
    """What a torque in a joint does to the arm, held as it was.

    Parameters
    ----------
    dof_names : tuple of str
        Rows of the spectra.
    spectra : tuple of (n_dof, 3 n_bins) complex array
        Force on the deflections, one per record.
    errors : dict of (str, int) to (n_bins,) complex array
        By joint and record: a sample of the error of torques that see a measured twist.
    """

    dof_names: tuple[str, ...]
    spectra: tuple[Spectrum, ...]
    errors: Mapping[tuple[str, int], Spectrum] = field(default_factory=dict)


@dataclass(frozen=True)
class Ripple:
    """Transmission error of one gear: a twist of its output that follows the motor angle.

    Parameters
    ----------
    joint : str
        Joint.
    order_per_rad : float
        Periods per radian of the joint, times 2π.
    sine_rad, cosine_rad : float [rad]
        Amplitudes.
    """

    joint: str
    order_per_rad: float
    sine_rad: float
    cosine_rad: float


@dataclass(frozen=True)
class Tone:
    """A steady periodic force of unknown amplitudes and phases in every record.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Of its fundamental.
    place : str
        Joint or link it acts on.
    force : bool
        A force on a link at its origin, in any direction, instead of a torque in a joint.
    orders : tuple of int
        Harmonics it has.
    """

    frequency_hz: float
    place: str
    force: bool = False
    orders: tuple[int, ...] = (1,)

    @property
    def lines_hz(self) -> tuple[float, ...]:
        """Where it shows [Hz]."""
        return tuple(order * self.frequency_hz for order in self.orders)
