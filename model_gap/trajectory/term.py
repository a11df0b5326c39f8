"""One law: columns that a quantity is a weighted sum of, with what is known of the weights."""

from abc import ABC, abstractmethod
from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from model_gap.trajectory.motion import Motion
from model_gap.trajectory.rigid import RigidTorque
from structural_model.description import KnownEffect, KnownNumber

Array = NDArray[np.float64]
TORQUE, TWIST = 'torque', 'twist'


@dataclass(frozen=True)
class Track:
    """One recording as laws see it.

    Parameters
    ----------
    motion : Motion
        What was measured.
    rigid : RigidTorque
        The rigid arm along it.
    load_nm : (n, n_joints) array [N m]
        What passes through the gears, by the best model so far: without rotors and friction.
    known : dict of str to (n, n_rows) array
        What the model predicts of each quantity, known effects included.
    compliance : (n_joints,) array [rad/(N m)]
        Of the model's springs between motor and link; 0 where it has none.
    added_nm : (n, n_joints) array [N m]
        Of the load what laws add that the model lacks: payload, counterbalance; not what masses
        within their tolerances do.
    """

    motion: Motion
    rigid: RigidTorque
    load_nm: Array
    known: Mapping[str, Array]
    compliance: Array
    added_nm: Array

    def measured(self, quantity: str) -> Array:
        """Return what was measured of a quantity, (n, n_rows)."""
        return self.motion.torque_nm if quantity == TORQUE else self.motion.twist_rad

    def left_by_model(self, quantity: str) -> Array:
        """Return what the model as it was given leaves over of a quantity, (n, n_rows)."""
        return self.measured(quantity) - self.known[quantity]

    def left(self, quantity: str) -> Array:
        """Return what is left over for laws of a quantity, (n, n_rows)."""
        return self.measured(quantity) - self.expected(quantity)

    def expected(self, quantity: str) -> Array:
        """Return what is predicted without laws of that quantity, (n, n_rows).

        A load that laws of the torques add, a payload's, twists the model's springs as well.
        """
        if quantity == TORQUE:
            return self.known[quantity]
        joints = list(self.motion.encoders)
        return self.known[quantity] + self.added_nm[:, joints] * self.compliance[joints]

    @property
    def n_joints(self) -> int:
        """Number of axes."""
        return int(self.rigid.total.shape[1])

    def column(self, axis: int, values: Array, width: int) -> Array:
        """Return values (n,) or (n, k) as columns that act on one axis, (n, width, k)."""
        values = values.reshape(len(values), -1)
        columns = np.zeros((len(values), width, values.shape[1]))
        columns[:, axis] = values
        return columns


@dataclass(frozen=True)
class Weight:
    """A number a law is linear in.

    Parameters
    ----------
    name, unit : str
        As reported.
    scale : float
        Prior standard deviation about zero: what is plausible.
    """

    name: str
    unit: str
    scale: float


@dataclass(frozen=True)
class Term(ABC):
    """A law at a place; immutable, without numbers of its own but those of its shape.

    Parameters
    ----------
    location : str
        Joint, link or encoder.
    axis : int
        Row it acts on: axis of the torque, place among the encoders of the twist.
    joint : int
        Joint it belongs to.
    shape : float
        What it is not linear in; NaN where there is no such number.
    """

    type: ClassVar[str]
    quantity: ClassVar[str] = TORQUE
    variant: ClassVar[str] = ''
    equation: ClassVar[str]
    says: ClassVar[str]
    # What to record to learn more of it.
    experiment: ClassVar[str] = ''
    # Whether it loads the gear (and twists it), rather than the motor alone.
    carried: ClassVar[bool] = False
    # Whether it can only add to a model that has none of it: no gear is stiffer than rigid.
    one_way: ClassVar[bool] = False
    # Where the corrected model keeps it: see ``KnownEffect``.
    kept_in: ClassVar[str] = 'effects'
    shape_name: ClassVar[str] = ''
    shape_unit: ClassVar[str] = ''
    shapes: ClassVar[tuple[float, ...]] = (float('nan'),)

    location: str
    axis: int
    joint: int
    shape: float = float('nan')

    @abstractmethod
    def weights(self) -> tuple[Weight, ...]:
        """Return what it is linear in."""

    @abstractmethod
    def columns(self, track: Track) -> Array:
        """Return the columns along a recording, (n, n_rows, n_weights)."""

    def local_columns(self, track: Track) -> Array:
        """Return columns whose weights are every recording's own, (n, n_rows, n_local)."""
        return np.zeros((track.motion.count, self.rows(track), 0))

    def local_scale(self) -> float:
        """Return the prior standard deviation of those weights."""
        return 1.0

    def rows(self, track: Track) -> int:
        """Return how many rows the quantity has."""
        return track.n_joints if self.quantity == TORQUE else len(track.motion.encoders)

    def numbers(self, weights: Array, covariance: Array) -> dict[str, tuple[float, float, str]]:
        """Return what is reported, by name: value, standard deviation, unit."""
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return {
            item.name: (float(value), float(sigma), item.unit)
            for item, value, sigma in zip(self.weights(), weights, deviations, strict=True)
        }

    def weights_of(self, numbers: Mapping[str, float]) -> Array:
        """Return the weights of reported numbers: the reverse of :meth:`numbers`."""
        return np.array([numbers[item.name] for item in self.weights()])

    def possible(self, weights: Array, known: Container[tuple[str, str]]) -> bool:
        """Return whether weights make sense in a model that has the known laws."""
        return not self.one_way or weights[0] > 0.0 or self.key in known

    def recentred(self, weights: Array) -> 'Term':
        """Return it linear about other weights; itself where it is linear everywhere."""
        return self

    def sentence(self, numbers: Mapping[str, float]) -> str:
        """Return what it says of the robot with these numbers."""
        return self.says.format(place=self.location.replace('_', ' '), **numbers)

    @property
    def key(self) -> tuple[str, str]:
        """Type and location: the same law with another shape has the same."""
        return self.type, self.location

    @property
    def label(self) -> str:
        """Type and place for people."""
        return f'{self.type.replace("_", " ")} at {self.location}'

    def known(self, weights: Array, covariance: Array, shape_sigma: float = 0.0) -> KnownEffect:
        """Return it as the model file lists it."""
        parameters = [
            KnownNumber(name, value, sigma, unit)
            for name, (value, sigma, unit) in self.numbers(weights, covariance).items()
        ]
        if self.shape_name:
            parameters.append(
                KnownNumber(self.shape_name, self.shape, shape_sigma, self.shape_unit)
            )
        return KnownEffect(self.type, self.location, self.variant, self.kept_in, tuple(parameters))
