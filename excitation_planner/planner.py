"""From a request to a plan: read this top to bottom and you have seen the planner."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from excitation_planner.allowed_range import allowed_range, AllowedRange, largest_change
from excitation_planner.approach import plan_approach
from excitation_planner.band_noise import band_noise_velocity, BandNoiseSettings
from excitation_planner.limits import check_limits, Envelope, PlanLimits
from excitation_planner.participation import forecast, ModeForecast, ModeParticipation
from excitation_planner.plan import ExcitationPlan, rounded, sealed
from excitation_planner.prediction import PlanPrediction
from excitation_planner.pulses import Pulse, pulse_velocity, PulseSettings, random_pulses
from excitation_planner.quickest_shape import LEAST_ACCELERATION, LEAST_JERK
from excitation_planner.request import PlanRequest
from excitation_planner.sensitivity import actual_change
from excitation_planner.signals import APPROACH, BAND_LIMITED_NOISE
from excitation_planner.spectrum import predicted_spectrum, PredictedSpectrum, whiteness
from excitation_planner.torque_projection import (
    require_full_rank,
    torque_projection,
    TorqueProjection,
)
from excitation_planner.trajectory import Trajectory
from modal_core.channel import Channel, SensorLayout
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Setting:
    """A request brought together with a robot.

    Parameters
    ----------
    request : PlanRequest
        What was asked.
    model : FlexibleJointModel
        The robot.
    channels : tuple of Channel
        Sensors of the cell.
    start : (n_joints,) array [rad]
        Serial joints.
    weights : (n_joints,) array
        Relative amplitude of every controller axis, 0 for one that rests.
    """

    request: PlanRequest
    model: FlexibleJointModel
    channels: tuple[Channel, ...]
    start: Array
    weights: Array


def plan_excitation(
    model: FlexibleJointModel, layout: SensorLayout | None, request: PlanRequest
) -> ExcitationPlan:
    """Make a plan, of an excitation or of the approach to one, check it, and seal it.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout or None
        The sensors; without them every mode counts as missed.
    request : PlanRequest
        What is asked.

    Raises
    ------
    PlanError, ModelError, LayoutError
        An unknown joint or link, a pose outside the range, a tolerance that no range meets,
        torques that do not span space, or a limit the motion breaks; each with the numbers.
    """
    if request.signal == APPROACH:
        here = model.check_pose(np.array(request.approach_from, dtype=float))
        limits = plan_limits(model, request)
        return plan_approach(here, _start(model, request), limits, request.sample_period_s)
    setting = bring_together(model, layout, request)
    projection = torque_projection(
        joint_axes(model, setting.start), setting.weights, model.joint_names
    )
    if request.require_full_rank:
        require_full_rank(projection)
    trajectory, peak_acceleration = _draw_motion(setting)
    envelope = check_limits(trajectory, plan_limits(model, request))
    # Samples round off the corners of a pulse; who plays it does not.
    peaks = np.maximum(envelope.peak_acceleration, peak_acceleration)
    envelope = replace(envelope, peak_acceleration=peaks)
    return _sealed_plan(setting, trajectory, projection, envelope)


def bring_together(
    model: FlexibleJointModel, layout: SensorLayout | None, request: PlanRequest
) -> Setting:
    """Resolve the names and the pose of a request."""
    joints = request.joints or model.joint_names
    for joint in joints:
        if joint not in model.joint_names:
            raise PlanError(
                'unknown joint', where='joints', found=joint, expected=', '.join(model.joint_names)
            )
    shares = request.joint_weights or (1.0,) * len(joints)
    if len(shares) != len(joints) or not any(shares):
        raise PlanError(
            'not one weight per moving joint, or all 0',
            where='joint_weights',
            found=list(shares),
            expected=f'{len(joints)} numbers',
        )
    weights = np.zeros(len(model.joint_names))
    for joint, share in zip(joints, shares, strict=True):
        weights[model.joint_names.index(joint)] = share
    if layout is not None:
        layout.check_links(model.link_names, model.robot_name)
    return Setting(
        request=request,
        model=model,
        channels=layout.channels if layout is not None else (),
        start=_start(model, request),
        weights=weights,
    )


def draw_trajectory(setting: Setting) -> Trajectory:
    """Draw the motion a request asks for; its randomness comes from the seed alone."""
    return _draw_motion(setting)[0]


def _draw_motion(setting: Setting) -> tuple[Trajectory, Array]:
    """Return the motion, and the peak acceleration of its pulses before they were sampled."""
    request, weights = setting.request, setting.weights
    generator = np.random.default_rng(request.seed)
    period_s, peaks = request.sample_period_s, np.zeros(len(weights))
    if request.signal == BAND_LIMITED_NOISE:
        noise = BandNoiseSettings(
            acceleration_rms=request.acceleration_rms * weights,
            band_hz=(request.band_low_hz, request.band_high_hz),
            ramp_s=request.fade_s,
            shape_frequency_hz=request.shape_frequency_hz,
            shape_gain=request.shape_gain,
        )
        velocity = band_noise_velocity(noise, request.duration_s, period_s, generator)
    else:
        pulses = random_pulses(pulse_settings(setting), request.duration_s, period_s, generator)
        if not pulses:
            raise PlanError(
                'no pulse and its way back fit',
                where='duration_s',
                found=f'{request.duration_s:g} s',
                advice='lengthen the plan, shorten the pauses or narrow the range',
            )
        velocity = pulse_velocity(pulses, round(request.duration_s / period_s) + 1, period_s)
        peaks = np.max([_peak_acceleration(pulse, setting.model) for pulse in pulses], axis=0)
    # Signals are drawn for the controller axes: those are what the drives move independently.
    serial = setting.model.to_serial(velocity)
    return Trajectory.from_velocity(setting.start, serial, period_s), peaks


def _peak_acceleration(pulse: Pulse, model: FlexibleJointModel) -> Array:
    return np.asarray(np.abs(model.to_serial(pulse.displacement)) * pulse.shape.peak_acceleration)


def pulse_settings(setting: Setting) -> PulseSettings:
    """Return how pulses are drawn: the range is the allowed one unless a smaller one is asked."""
    request, limits = setting.request, setting.model.limits
    half_range = request.half_range * setting.weights
    if request.half_range == 0.0 or request.enforce_tolerance:
        allowed = find_allowed_range(setting)
        if request.half_range == 0.0:
            half_range = allowed.half_range
        elif np.any(half_range > allowed.half_range):
            worst = int(np.argmax(half_range / np.maximum(allowed.half_range, 1e-12)))
            raise PlanError(
                'the range changes a natural frequency by more than the tolerance',
                where=f'half_range of {setting.model.joint_names[worst]}',
                found=f'{np.rad2deg(half_range[worst]):.3f} deg',
                expected=f'<= {np.rad2deg(allowed.half_range[worst]):.3f} deg for'
                f' {100 * request.frequency_tolerance:g} %',
            )
    n_moving = int(np.count_nonzero(setting.weights))

    def travel_m(displacement: Array) -> float:
        move = setting.model.to_serial(displacement)
        fastest = setting.model.geometry.fastest_point(setting.start[None], move[None])
        return float(fastest.speed_m_s[0])

    # Wherever the request allows it, moves are such that a program of the controller makes them.
    playable = (
        request.synchronised
        and request.jerk_limited
        and request.acceleration_high >= LEAST_ACCELERATION
    )
    return PulseSettings(
        half_range=half_range,
        peak_velocity=limits.velocity,
        peak_acceleration=limits.acceleration,
        interval_s=(request.interval_low_s, request.interval_high_s),
        acceleration_fraction=(request.acceleration_low, request.acceleration_high),
        ramp_s=(request.ramp_low_s, request.ramp_high_s),
        speed_fraction=(request.speed_low, request.speed_high),
        point_speed_m_s=request.point_speed_m_s / (1 if request.synchronised else n_moving),
        point_travel_m=travel_m,
        synchronised=request.synchronised,
        least_acceleration=LEAST_ACCELERATION * limits.acceleration if playable else None,
        least_jerk=LEAST_JERK * limits.jerk if playable else None,
    )


def find_allowed_range(setting: Setting) -> AllowedRange:
    """Return the largest joint range that keeps the frequency tolerance."""
    request = setting.request
    change = actual_change(setting.model, setting.start, request.band_high_hz)
    return allowed_range(
        change,
        setting.start,
        setting.weights / np.max(setting.weights),
        request.frequency_tolerance,
        setting.model.limits,
        np.random.default_rng([request.seed, 1]),
    )


def plan_limits(model: FlexibleJointModel, request: PlanRequest) -> PlanLimits:
    """Return the limits a request is checked against."""
    box = None
    if request.box_m:
        low_x, low_y, low_z, high_x, high_y, high_z = request.box_m
        box = ((low_x, low_y, low_z), (high_x, high_y, high_z))
    return PlanLimits(
        model=model,
        point_speed_m_s=request.point_speed_m_s,
        box_m=box,
        clearance_m=request.clearance_m,
        jerk_limited=request.jerk_limited,
        guided=request.signal == BAND_LIMITED_NOISE,
    )


def joint_axes(model: FlexibleJointModel, q: Array) -> Array:
    """Return the joint axes in the base frame, (n_joints, 3); zero for a prismatic joint."""
    rotation = model.kinematics.motion(q).rotation[0, 1:]
    axes = np.array([joint.axis for joint in model.robot.joints])
    turns = np.array([not joint.prismatic for joint in model.robot.joints])
    return np.asarray(np.einsum('jab,jb->ja', rotation, axes) * turns[:, None])


def mode_participation(
    model: FlexibleJointModel, q: Array, channels: tuple[Channel, ...], highest_hz: float
) -> ModeParticipation:
    """Return drive and response of the model's modes up to a frequency."""
    modes = model.modes(q, channels)
    keep = modes.frequency_hz <= highest_hz
    return ModeParticipation(
        frequency_hz=modes.frequency_hz[keep],
        damping_ratio=modes.damping_ratio[keep],
        drive=modes.shapes[:, keep].T @ model.input_matrix(q) @ np.linalg.inv(model.axes.matrix),
        response=modes.channel_shapes[:, keep],
        channel_names=tuple(channel.name for channel in channels),
        joint_names=model.joint_names,
    )


def forecast_modes(
    setting: Setting, spectrum: PredictedSpectrum, duration_s: float
) -> tuple[ModeForecast, ...]:
    """Predict how every mode up to the highest frequency of interest will show."""
    request = setting.request
    modes = mode_participation(
        setting.model, setting.start, setting.channels, request.band_high_hz
    )
    return forecast(modes, spectrum, request.noise_density**2, duration_s)


def _start(model: FlexibleJointModel, request: PlanRequest) -> Array:
    if request.start_position:
        return model.check_pose(np.array(request.start_position, dtype=float))
    if not model.poses_controller_rad:
        raise PlanError('no start pose', where='start_position', found='nothing')
    return model.check_pose(model.pose(next(iter(model.poses_controller_rad))))


def _sealed_plan(
    setting: Setting, trajectory: Trajectory, projection: TorqueProjection, envelope: Envelope
) -> ExcitationPlan:
    request, model = setting.request, setting.model
    acceleration = model.to_controller(trajectory.acceleration)
    spectrum = predicted_spectrum(acceleration, trajectory.sample_period_s)
    band_hz = spectrum.excited_band_hz()
    modes = forecast_modes(setting, spectrum, trajectory.duration_s)
    changes = _largest_changes(setting, trajectory)
    if request.enforce_tolerance and np.any(changes > request.frequency_tolerance):
        raise _too_wide(modes, changes, request)
    inside = [i for i, mode in enumerate(modes) if band_hz[0] <= mode.frequency_hz <= band_hz[1]]
    return sealed(
        ExcitationPlan(
            seed=request.seed,
            robot_name=model.robot_name,
            signal=request.signal,
            joint_names=tuple(model.joint_names),
            start_position=trajectory.position[0].copy(),
            position_range=np.ptp(trajectory.position, axis=0),
            peak_velocity=rounded(envelope.peak_velocity),
            peak_acceleration=rounded(envelope.peak_acceleration),
            peak_point_speed=float(rounded(envelope.peak_point_speed_m_s)),
            duration_s=trajectory.duration_s,
            band_low_hz=band_hz[0],
            band_high_hz=band_hz[1],
            torque_projection_rank=projection.rank,
            mode_frequency_hz=rounded([modes[i].frequency_hz for i in inside]),
            mode_frequency_sensitivity=rounded([changes[i] for i in inside]),
            mode_signal_to_noise_db=rounded([modes[i].signal_to_noise_db for i in inside]),
            sample_period_s=trajectory.sample_period_s,
            position=trajectory.position,
            velocity=trajectory.velocity,
            prediction=_prediction(
                acceleration, trajectory.sample_period_s, spectrum, projection, modes, envelope
            ),
        )
    )


def _largest_changes(setting: Setting, trajectory: Trajectory) -> Array:
    """Return Eq. (1) for every mode, the largest over the box the trajectory stays in."""
    axis = setting.model.to_controller(trajectory.position)
    return largest_change(
        actual_change(setting.model, setting.start, setting.request.band_high_hz),
        setting.start,
        np.min(axis, axis=0),
        np.max(axis, axis=0),
        setting.model.limits,
    )


def _prediction(
    acceleration: Array,
    sample_period_s: float,
    spectrum: PredictedSpectrum,
    projection: TorqueProjection,
    modes: tuple[ModeForecast, ...],
    envelope: Envelope,
) -> PlanPrediction:
    band_hz = spectrum.excited_band_hz()
    notices = [
        f'mode at {mode.frequency_hz:.2f} Hz would be missed: {mode.reason}'
        for mode in modes
        if mode.missed
    ]
    if projection.rank < 3:
        notices.append(projection.reason)
    return PlanPrediction(
        spectrum=spectrum,
        whiteness=tuple(
            whiteness(column, sample_period_s, band_hz) if np.any(column) else None
            for column in acceleration.T
        ),
        flatness_db=spectrum.flatness_db(band_hz),
        projection=projection,
        modes=modes,
        envelope=envelope,
        notices=tuple(notices),
    )


def _too_wide(modes: tuple[ModeForecast, ...], changes: Array, request: PlanRequest) -> PlanError:
    worst = int(np.argmax(changes))
    return PlanError(
        f'the motion changes the mode at {modes[worst].frequency_hz:.2f} Hz too much',
        where='frequency_tolerance',
        found=f'{100 * changes[worst]:.3g} %',
        expected=f'<= {100 * request.frequency_tolerance:.3g} %',
        advice='narrow the motion or raise the tolerance',
    )
