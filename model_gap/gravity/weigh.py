"""Find what makes gravity read wrong: one fault after the other, as long as the means demand it.

The means are m = u(q + δ) + tolerances + noise.  With their tolerances as covariance,
-log L = ½ eᵀ Σ⁻¹ e of what is left, e, says how much a fault explains.
"""

from collections.abc import Iterator, Sequence
import dataclasses
from dataclasses import dataclass
from itertools import combinations, permutations, product

import numpy as np
from numpy.typing import NDArray
import scipy.linalg

from model_gap.cell import Tolerances
from model_gap.gravity.at_rest import AtRest, G_M_S2
from model_gap.gravity.faults import COST, Fault, Kind
from model_gap.gravity.usual import covariance, USUAL

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GravityLimits:
    """What counts as a fault.

    Parameters
    ----------
    worth_naming : float
        Log evidence, as of an effect.
    between : float
        Log evidence by which two explanations can be told apart.
    most : int
        Faults beside units, at most: so many may stand for one that is not thought of.
    left_m_s2 : float [m/s²]
        Root mean square of what is left, above which more is wrong than was found: gravity turned
        by three degrees; zero offsets drift by a tenth of that.
    poses : int
        Tried, for one that tells two explanations apart.
    open_deg : float [deg]
        An encoder known to no better than that is not told by gravity.
    """

    worth_naming: float = 12.0
    between: float = 8.0
    most: int = 5
    left_m_s2: float = 0.5
    poses: int = 64
    open_deg: float = 1.0


LIMITS = GravityLimits()
POSE_SEED = 0
# What is plausible, as of the effect ``sensor_gain``.
GAINS = 0.02, 10.0
# All ways three axes can be plugged and mounted, but the right one.
ORIENTATIONS = tuple(
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
    if not (order == (0, 1, 2) and signs == (1.0, 1.0, 1.0))
)


def weigh(rest: AtRest, tolerances: Tolerances) -> tuple[Fault, ...]:
    """Return what gravity shows to be wrong, the most telling first; nothing on healthy data."""
    found: list[Fault] = []
    while rest.channels:
        state = _State.of(rest, found, tolerances)
        if state.cost < LIMITS.worth_naming:
            break
        if sum(fault.kind is not Kind.UNIT for fault in found) == LIMITS.most:
            return _untold(rest, found, tolerances)
        tried = sorted(state.candidates(found), key=lambda fault: -fault.gain)
        if not tried or tried[0].gain < LIMITS.worth_naming:
            return _untold(rest, found, tolerances) if state.left > LIMITS.left_m_s2 else (*found,)
        best = tried[0]
        close = [it for it in tried[1:] if it.gain > best.gain - LIMITS.between]
        other = [it for it in close if not _alike(it, best)]
        if other:
            telling = _telling(rest, found, best, other[0])
            best = dataclasses.replace(best, rival=other[0], telling=telling)
        found.append(best)
    return tuple(found)


def _untold(rest: AtRest, found: Sequence[Fault], tolerances: Tolerances) -> tuple[Fault, ...]:
    """Return what stays where more is wrong than was found: units, which are known exactly."""
    units = [fault for fault in found if fault.kind is Kind.UNIT]
    return (*units, _State.of(rest, units, tolerances).untold())


def _alike(one: Fault, other: Fault) -> bool:
    """Return whether two faults are one: a wrong unit is a gain, and known exactly."""
    scales = {one.kind, other.kind} <= {Kind.UNIT, Kind.GAIN}
    return one.place == other.place and (scales or one.kind is other.kind)


def encoders_told(rest: AtRest, tolerances: Tolerances) -> dict[str, float]:
    """Return to how many degrees gravity tells the zero of each encoder, by joint; inf: not."""
    if not rest.channels:
        return dict.fromkeys(rest.model.joint_names, np.inf)
    state = _State.of(rest, (), tolerances)
    found = {}
    for joint, slope in zip(rest.model.joint_names, state.slopes, strict=True):
        sigma = np.degrees(state.size_of(slope)[1]) if _seen(slope) else np.inf
        found[joint] = float(sigma) if sigma < LIMITS.open_deg else np.inf
    return found


def _seen(slope: Array) -> bool:
    """Return whether gravity tells of a joint at all: not about an upright axis."""
    return bool(np.abs(slope).max() * USUAL.encoder_rad > USUAL.noise_m_s2 / 10.0)


def _telling(rest: AtRest, known: Sequence[Fault], one: Fault, other: Fault) -> str:
    """Return the pose in which two explanations differ most."""
    limits, rng = rest.model.limits, np.random.default_rng(POSE_SEED)
    low = np.maximum(limits.position_low, -np.pi)
    high = np.minimum(limits.position_high, np.pi)
    poses = rng.uniform(low, high, (LIMITS.poses, len(low)))
    elsewhere = rest.in_poses(poses)
    means = [_readings(elsewhere, (*known, fault)) for fault in (one, other)]
    apart = np.linalg.norm(means[0] - means[1], axis=1)
    best = int(np.argmax(apart))
    return (
        f'stand still at {rest.model.joints_words(poses[best])}: the means of {one.words()} and '
        f'of {other.words()} would differ by {apart[best]:.2f} m/s² there'
    )


def _as_it_stands(rest: AtRest, faults: Sequence[Fault]) -> tuple[AtRest, Array]:
    """Return sensors in the poses that faults leave, and by how much each joint is off [rad]."""
    offset = np.zeros(len(rest.model.joint_names))
    for fault in faults:
        if fault.kind is Kind.JOINTS:
            travels = tuple(travel.changed(fault.exchanged) for travel in rest.travels)
            rest = dataclasses.replace(rest, travels=travels)
        elif fault.kind is Kind.ENCODER:
            offset[fault.columns[0]] += fault.values[0]
    return rest, offset


def _readings(rest: AtRest, faults: Sequence[Fault]) -> Array:
    """Return what should be read with some faults, (n_records, n_channels)."""
    rest, offset = _as_it_stands(rest, faults)
    readings = rest.predicted(offset)
    for fault in faults:
        if fault.kind is Kind.TILT:
            readings = readings + np.tensordot(fault.values, rest.tilts(offset), 1)
    for fault in faults:
        readings = _applied(readings, fault)
    return readings


def _slopes(rest: AtRest, faults: Sequence[Fault]) -> tuple[Array, Array]:
    """Return the derivatives of the readings by offsets of the joints and by tilts."""
    rest, offset = _as_it_stands(rest, faults)
    slopes = np.concatenate([rest.slopes(offset), rest.tilts(offset)])
    for fault in faults:
        if fault.kind is not Kind.ZERO:  # of a slope no zero offset is left
            slopes = np.array([_applied(slope, fault) for slope in slopes])
    return slopes[:-2], slopes[-2:]


def _applied(readings: Array, fault: Fault) -> Array:
    """Return what would be read, (n_records, n_channels), with one more fault of a sensor."""
    columns, wrong = list(fault.columns), readings.copy()
    if fault.kind is Kind.ZERO:
        wrong[:, columns] += fault.values[0]
    elif fault.kind is Kind.UNIT:
        wrong[:, columns] /= G_M_S2
    elif fault.kind is Kind.GAIN:
        wrong[:, columns] *= fault.values[0]
    elif fault.kind in (Kind.AXES, Kind.TURNED):
        wrong[:, columns] = wrong[:, columns] @ fault.matrix.T
    elif fault.kind is Kind.SENSORS:
        wrong = fault.exchanged(wrong)
    return wrong


@dataclass(frozen=True)
class _State:
    """Means, and what the faults found so far leave of them."""

    rest: AtRest
    predicted: Array
    slopes: Array
    tilts: Array
    factor: tuple[Array, bool]
    cost: float

    @classmethod
    def of(cls, rest: AtRest, faults: Sequence[Fault], tolerances: Tolerances) -> '_State':
        predicted, (slopes, tilts) = _readings(rest, faults), _slopes(rest, faults)
        usual = covariance(rest, predicted, slopes, tilts, tolerances)
        read = rest.read.ravel()
        factor = scipy.linalg.cho_factor(usual[np.ix_(read, read)])
        state = cls(rest, predicted, slopes, tilts, factor, 0.0)
        return dataclasses.replace(state, cost=state.cost_of(rest.measured - predicted))

    def solved(self, values: Array) -> Array:
        """Return Σ⁻¹ times means, (n_means, ...): what was not read weighs nothing."""
        read, found = self.rest.read.ravel(), np.zeros(values.shape)
        found[read] = scipy.linalg.cho_solve(self.factor, values[read])
        return found

    def cost_of(self, left: Array) -> float:
        """Return -log L of what is left over."""
        flat = left.ravel()
        return 0.5 * float(flat @ self.solved(flat))

    def candidates(self, known: Sequence[Fault]) -> Iterator[Fault]:
        """Return every fault that is not known yet, with what it gains."""
        taken = {(fault.kind, fault.place) for fault in known}
        mixed = {fault.place for fault in known if fault.kind in (Kind.AXES, Kind.TURNED)}
        for fault in (*self._all(), *self._exchanged_joints(known)):
            oriented = fault.kind in (Kind.AXES, Kind.TURNED) and fault.place in mixed
            if (fault.kind, fault.place) not in taken and not oriented:
                yield fault

    def _all(self) -> Iterator[Fault]:
        for number, joint in enumerate(self.rest.model.joint_names):
            if _seen(self.slopes[number]):
                yield self._moved(Fault(Kind.ENCODER, joint, (number,)), self.slopes[[number]])
        yield self._moved(Fault(Kind.TILT, 'base', ()), self.tilts)
        for number, channel in enumerate(self.rest.channels):
            value, sigma = self.size_of(np.eye(len(self.rest.channels))[number])
            yield self._gaining(Fault(Kind.ZERO, channel.name, (number,), (value,), sigma))
            yield from self._scaled(channel.name, (number,))
        for sensor, columns in self.rest.sensors.items():
            yield self._gaining(Fault(Kind.UNIT, sensor, tuple(columns)))
            yield from self._scaled(sensor, tuple(columns))
            if len(columns) == 3:
                yield from self._oriented(sensor, tuple(columns))

        for (one, own), (two, its) in combinations(self.rest.sensors.items(), 2):
            together = bool((self.rest.read[:, own[0]] == self.rest.read[:, its[0]]).all())
            if len(own) == len(its) and together:
                yield self._gaining(Fault.exchange(Kind.SENSORS, (one, two), (*own, *its)))

    def _exchanged_joints(self, known: Sequence[Fault]) -> Iterator[Fault]:
        for one, two in combinations(range(len(self.rest.model.joint_names)), 2):
            names = self.rest.model.joint_names
            fault = Fault.exchange(Kind.JOINTS, (names[one], names[two]), (one, two))
            yield self._gaining(fault, _readings(self.rest, (*known, fault)))

    @property
    def left(self) -> float:
        """Root mean square of what is not explained [m/s²]."""
        left = (self.rest.measured - self.predicted)[self.rest.read]
        return float(np.sqrt(np.mean(left**2)))

    def untold(self) -> Fault:
        """Return that something is wrong that no fault explains."""
        left = np.where(self.rest.read, self.rest.measured - self.predicted, np.nan)
        square = np.nanmean(left**2, axis=0)
        most = self.rest.channels[int(np.argmax(square))]
        return Fault(Kind.UNTOLD, most.sensor, (), (self.left,))

    def _gaining(self, fault: Fault, predicted: Array | None = None) -> Fault:
        predicted = _applied(self.predicted, fault) if predicted is None else predicted
        cost = self.cost_of(self.rest.measured - predicted)
        return dataclasses.replace(fault, gain=self.cost - cost - COST[fault.kind])

    def _scaled(self, place: str, columns: tuple[int, ...]) -> Iterator[Fault]:
        """Return the gain of a sensor or channel: without it, encoders are blamed for one."""
        pattern = np.zeros_like(self.predicted)
        pattern[:, columns] = self.predicted[:, columns]
        more, sigma = self.size_of(pattern)
        if GAINS[0] < 1.0 + more < GAINS[1]:
            yield self._gaining(Fault(Kind.GAIN, place, columns, (1.0 + more,), sigma))

    def size_of(self, pattern: Array) -> tuple[float, float]:
        """Return the size of a pattern of the means, and its deviation."""
        wide = np.broadcast_to(pattern, self.predicted.shape).ravel()
        weight = self.solved(wide)
        power = float(wide @ weight)
        if power <= 0.0:
            return 0.0, np.inf
        left = (self.rest.measured - self.predicted).ravel()
        return float(weight @ left) / power, power**-0.5

    def _moved(self, fault: Fault, patterns: Array) -> Fault:
        """Return a fault that adds patterns to the means, at its size: least squares."""
        rows = patterns.reshape(len(patterns), -1)
        weight = self.solved(rows.T)
        left = self.rest.measured - self.predicted
        spread = np.linalg.pinv(rows @ weight)
        values = spread @ (weight.T @ left.ravel())
        cost = self.cost_of(left - np.tensordot(values, patterns, 1))
        return dataclasses.replace(
            fault,
            values=tuple(values.tolist()),
            sigma=float(np.sqrt(spread[0, 0])),
            gain=self.cost - cost - COST[fault.kind],
        )

    def _oriented(self, sensor: str, columns: tuple[int, ...]) -> Iterator[Fault]:
        tried = [
            self._gaining(Fault(Kind.AXES, sensor, columns, tuple(matrix.ravel())))
            for matrix in ORIENTATIONS
        ]
        yield max(tried, key=lambda fault: fault.gain)
        there = self.rest.read[:, columns].all(axis=1)
        own, read = (it[there][:, columns] for it in (self.predicted, self.rest.measured))
        left, _, right = np.linalg.svd(read.T @ own)
        proper = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
        turned = tuple(float(value) for value in (left @ proper @ right).ravel())
        yield self._gaining(Fault(Kind.TURNED, sensor, columns, turned))
