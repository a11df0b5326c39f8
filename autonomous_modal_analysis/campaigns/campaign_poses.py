"""Poses for a campaign: far apart, inside every limit, with every mode in sight."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.forecast import forecast, mode_participation
from excitation_planner.motion import PredictedSpectrum
from excitation_planner.request import PlanRequest
from excitation_planner.setting import stated_weights
from modal_core.channel import SensorLayout
from modal_core.errors import ModelError, PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
DRAWS = 400
# Part of each range that is kept away from at its ends, and the widest range of an axis.
MARGIN, WIDEST_RAD = 0.08, np.deg2rad(340.0)
LEAST_CLEARANCE_M = 0.03
# What noise keeps below, over its rms: beyond five deviations lie 6e-7 of it.
CREST = 5.0
LEAST_HEIGHT_M = 0.1
# Of the arms these two are for; smaller ones keep less, in proportion.
USUAL_REACH_M = 2.0
# Candidates whose weakest mode is among the worst seen of this part are left out.
WORST = 0.3


@dataclass(frozen=True)
class Candidates:
    """Poses an arm can take.

    Parameters
    ----------
    pose : (n, n_joints) array [rad]
        Serial joints.
    place : (n, n_features) array
        Angles by their range and natural frequencies by their scatter: what makes poses differ.
    weakest_db : (n,) array [dB]
        Signal to noise of the mode that would be seen worst.
    """

    pose: Array
    place: Array
    weakest_db: Array


def choose_poses(
    model: FlexibleJointModel, layout: SensorLayout, count: int, request: PlanRequest
) -> list[Array]:
    """Return poses that differ as much as possible, in configuration and in modes.

    Candidates are drawn in the controller's ranges; those that come near the floor or the arm
    itself, and those that hide a mode from the sensors, are left out.  Of the rest the best seen
    one is taken first, then always the one farthest from all taken (Gonzalez 1985).

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout
        Its sensors.
    count : int
        How many.
    request : PlanRequest
        Band, amplitude, noise and seed of the motion; its box and clearance hold too.

    References
    ----------
    Gonzalez (1985), Clustering to minimize the maximum intercluster distance,
    doi:10.1016/0304-3975(85)90224-5.

    Raises
    ------
    PlanError
        Fewer poses than asked are possible.
    """
    found = _candidates(model, layout, request, np.random.default_rng([request.seed, 2]))
    # Where no mode is below the end of the band, nothing is seen.
    weakest = found.weakest_db[np.isfinite(found.weakest_db)]
    if len(found.pose) and not len(weakest):
        raise PlanError(
            'no mode below the end of the band in any pose',
            where=model.robot_name,
            found=f'{request.band_high_hz:g} Hz',
            advice='raise band_high_hz',
        )
    least_db = np.quantile(weakest, WORST) if len(weakest) else 0.0
    seen = np.flatnonzero(found.weakest_db >= least_db)
    if len(seen) < count:
        raise PlanError(
            'too few poses inside the limits',
            where=model.robot_name,
            found=len(seen),
            expected=count,
            advice='ask for fewer, widen the box, or name them with --pose-deg',
        )
    first = int(seen[np.argmax(found.weakest_db[seen])])
    taken = [first]
    distance = np.full(len(found.pose), np.inf)
    while len(taken) < count:
        newest = np.linalg.norm(found.place - found.place[taken[-1]], axis=1)
        distance = np.minimum(distance, newest)
        taken.append(int(seen[np.argmax(distance[seen])]))
    return [found.pose[number] for number in taken]


def _candidates(
    model: FlexibleJointModel,
    layout: SensorLayout,
    request: PlanRequest,
    generator: np.random.Generator,
) -> Candidates:
    limits = model.limits
    low = np.maximum(limits.controller_low, -WIDEST_RAD / 2.0)
    high = np.minimum(limits.controller_high, WIDEST_RAD / 2.0)
    size = high - low
    drawn = low + size * generator.uniform(MARGIN, 1.0 - MARGIN, (DRAWS, model.n_joints))
    poses, places, weakest, frequencies = [], [], [], []
    for angles in drawn:
        q = model.to_serial(angles)
        if not is_possible(model, q, request):
            continue
        modes = mode_participation(model, q, layout.channels, request.band_high_hz)
        density = request.acceleration_rms**2 / (request.band_high_hz - request.band_low_hz)
        flat = PredictedSpectrum(
            np.array([0.0, request.band_high_hz]), np.full((2, model.n_joints), density)
        )
        shown = forecast(modes, flat, request.noise_density**2, request.duration_s)
        poses.append(q)
        places.append(angles / size)
        weakest.append(min((mode.signal_to_noise_db for mode in shown), default=-np.inf))
        frequencies.append([mode.frequency_hz for mode in shown])
    if not poses:
        return Candidates(np.empty((0, model.n_joints)), np.empty((0, 1)), np.empty(0))
    # Modes that every pose has, for poses that shift them are worth more than ones that do not.
    common = min(len(row) for row in frequencies)
    pitch = np.log([row[:common] for row in frequencies])
    pitch = (pitch - pitch.mean(axis=0)) / np.maximum(pitch.std(axis=0), 1e-9)
    scale = np.std(places, axis=0).mean()
    return Candidates(
        np.array(poses), np.hstack([places, scale * pitch]), np.array(weakest, dtype=float)
    )


def is_possible(model: FlexibleJointModel, q: Array, request: PlanRequest) -> bool:
    """Return whether a pose keeps ranges, box and distances from the floor and the arm."""
    try:
        model.check_pose(q)
    except ModelError:
        return False
    points = model.geometry.skeleton(q)
    size = min(1.0, model.robot.reach_m / USUAL_REACH_M)
    # The base stands on the floor, and what the first joint turns stays as high as it is.
    lifted = [model.robot.links[name][0] > 1 for name, _ in model.geometry.skeleton_points]
    if points[lifted, 2].min(initial=np.inf) < points[0, 2] + size * LEAST_HEIGHT_M:
        return False
    if request.box_m:
        corners = np.array(request.box_m).reshape(2, 3)
        if np.any(points < corners[0]) or np.any(points > corners[1]):
            return False
    if not _holds(model, q, request):
        return False
    near = model.geometry.clearance(q)
    return near is None or near.distance_m >= max(size * LEAST_CLEARANCE_M, request.clearance_m)


def _holds(model: FlexibleJointModel, q: Array, request: PlanRequest) -> bool:
    """Return whether the drives can hold the arm and shake it, five deviations far."""
    size = request.acceleration_rms * stated_weights(model, request)
    still = np.zeros(model.n_joints)
    shaking = np.sqrt(model.link_inertia(q) ** 2 @ size**2)
    hold = np.abs(model.drive_torque(q, still, still))
    return bool(np.all(hold + CREST * shaking <= model.limits.effort))
