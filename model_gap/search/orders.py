"""Gear orders in what is left over: torques that go with the angle of a joint.

A gear that turns unevenly pushes its spring by a sin(N q) + b cos(N q).  Which N is not known, and
a fit finds it only from very near: it is sought like the line of a hum, joint by joint.  Motion
that is small against a period tells N by the poses only, up to aliases: a whole number of periods
per turn of the motor is then tried as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import hann, RecordSpectra
from model_gap.cell import axis_row, joint_spring, joint_vector, Ripple
from model_gap.fit import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor, transform_at
from model_gap.search.reach import free_force

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class OrderLimits:
    """Which orders are tried, and which count.

    Parameters
    ----------
    most_per_rad : float [1/rad]
        Highest order.
    usual : tuple of float
        Periods per turn of the motor.
    phase_step, pose_phase_step : float [rad]
        Of an order times the way of the joint in a record, and from pose to pose: finer says the
        same.
    least_way_rad, least_span_rad : float [rad]
        A joint that moves less is parked; poses that span less count as spanning this.
    least_gain : float
        Log evidence that an order must promise.
    apart : float
        Relative: closer orders are one.
    """

    most_per_rad: float = 2000.0
    usual: tuple[float, ...] = (1.0, 2.0, 0.5, 3.0, 4.0, 5.0, 6.0)
    phase_step: float = 0.5
    pose_phase_step: float = 0.3
    least_way_rad: float = 1e-6
    least_span_rad: float = 0.01
    least_gain: float = 3.0
    apart: float = 0.01


LIMITS = OrderLimits()


def orders_left(
    hypothesis: Hypothesis, predictor: Predictor, joints: Sequence[str]
) -> tuple[Ripple, ...]:
    """Return the ripples seen in each joint; none where they would explain next to nothing.

    Parameters
    ----------
    hypothesis : Hypothesis
        Its residual counts.
    predictor : Predictor
        Of the fitting records.
    joints : sequence of str
        Where to look.
    """
    cell = hypothesis.cell()
    systems = predictor.systems(cell.spec, cell.channels)
    rests = [
        item.measured - reading
        for item, reading in zip(predictor.records, predictor.predict(cell), strict=True)
    ]
    total = sum(
        float(np.sum(item.squares(rest)))
        for rest, item in zip(rests, predictor.records, strict=True)
    )

    def strongest(joint: str) -> list[Ripple]:
        place = joint_vector(predictor.model, joint, systems[0].dof_names)
        spring = joint_spring(cell.spec, joint)
        tracks = []
        for item, rest, group in zip(predictor.records, rests, predictor.groups, strict=True):
            omega = item.omega[:, 1]
            stiffness = spring.stiffness + 1j * omega * spring.damping
            response = cell.seen(omega, systems[group].response(omega, place)) * stiffness
            error, weight = free_force(rest, response, item.noise_power)
            angle = (item.record.pose + item.record.motor_shift) @ axis_row(predictor.model, joint)
            tracks.append(_Track(item, error, weight, angle))
        ratio = next(j.drive.gear_ratio for j in cell.spec.joints if j.name == joint)
        return _strongest(joint, tracks, total, ratio)

    return tuple(ripple for found in side_by_side(strongest, joints) for ripple in found)


@dataclass(frozen=True)
class _Track:
    """Angle of a joint in a record, and the gear's error that would explain what is left over.

    Parameters
    ----------
    item : RecordSpectra
        Which.
    error : (n_bins,) complex array
        Motion of the motor side of the spring.
    weight : (n_bins,) array
        Over its noise power.
    angle : (n_samples,) array [rad]
        Of the joint.
    """

    item: RecordSpectra
    error: NDArray[np.complex128]
    weight: Array
    angle: Array

    @property
    def middle(self) -> float:
        """Mean angle [rad]."""
        return float(self.angle.mean())

    @property
    def way(self) -> float:
        """Twice the deviation from the mean angle [rad]."""
        return 2.0 * float(self.angle.std())

    def normal(self, order: float) -> tuple[Array, Array]:
        """Return the normal equations (2, 2), (2,) of sine and cosine about the mean angle."""
        phase = order * (self.angle - self.middle)
        waves = [
            hann(transform_at(wave - wave.mean(), self.item).reshape(-1, 3))
            for wave in (np.sin(phase), np.cos(phase))
        ]
        weighted = np.conj(waves) * self.weight
        return (weighted @ np.transpose(waves)).real, (weighted @ self.error).real


def _strongest(joint: str, tracks: Sequence[_Track], total: float, ratio: float) -> list[Ripple]:
    """Return the orders that explain most, amplitudes the same in all records.

    The best of those usual in gears, and a better one if there is.
    """
    middles = np.array([track.middle for track in tracks])
    way = max(track.way for track in tracks)
    if way < LIMITS.least_way_rad:
        return []
    coarse_step = LIMITS.phase_step / way
    coarse = np.arange(0.5 * coarse_step, LIMITS.most_per_rad + coarse_step, coarse_step)
    step = LIMITS.pose_phase_step / max(float(np.ptp(middles)), LIMITS.least_span_rad)
    usual = np.array([ratio * turns for turns in LIMITS.usual if ratio > 1.0])
    orders = np.r_[usual, np.arange(step, LIMITS.most_per_rad, step)]
    nearest = np.abs(orders[:, None] - coarse).argmin(axis=1)
    left = np.full(len(orders), total)
    for number, order in enumerate(coarse):
        inside = nearest == number
        if inside.any():
            normals = [track.normal(order) for track in tracks]
            gram, pull = _common(normals, np.multiply.outer(orders[inside], middles))
            left[inside] -= np.sum(pull * _solved(gram, pull), axis=1)
    gain = FIT.effective_data * np.log(total / np.maximum(left, 1e-9 * total))
    best = {int(np.argmax(gain)), int(np.argmax(gain[: max(len(usual), 1)]))}
    found: list[Ripple] = []
    for number in sorted(best):
        order = float(orders[number])
        alike = any(abs(order / item.order_per_rad - 1.0) < LIMITS.apart for item in found)
        if gain[number] < LIMITS.least_gain or alike:
            continue
        normals = [track.normal(order) for track in tracks]
        sine, cosine = _solved(*_common(normals, order * middles[None]))[0].tolist()
        found.append(Ripple(joint, order, sine, cosine))
    return found


def _common(normals: Sequence[tuple[Array, Array]], phases: Array) -> tuple[Array, Array]:
    """Add the normal equations of records whose mean angles have phases (n, n_records).

    Returns
    -------
    (n, 2, 2) array, (n, 2) array
        For amplitudes that all records share.
    """
    cos, sin = np.cos(phases), np.sin(phases)
    turns = np.array([[cos, -sin], [sin, cos]])  # common amplitudes to those about a mean angle
    gram = np.einsum('jinr,rjk,klnr->nil', turns, [own for own, _ in normals], turns)
    return gram, np.einsum('jinr,rj->ni', turns, [push for _, push in normals])


def _solved(gram: Array, pull: Array) -> Array:
    """Solve (n, 2, 2), (n, 2); a direction that nothing says anything of stays at zero."""
    return np.asarray((np.linalg.pinv(gram, 1e-9, hermitian=True) @ pull[..., None])[..., 0])
