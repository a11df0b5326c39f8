"""From a request to a plan: read this top to bottom and you have seen the planner."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from excitation_planner.bounds import check_limits, Envelope, PlanLimits
from excitation_planner.drawing import draw_motion, exciting
from excitation_planner.forecast import (
    analysed_hz,
    ExpectedModes,
    forecast,
    mode_participation,
    ModeForecast,
    PlanPrediction,
    projection_along,
    require_full_rank,
    TorqueProjection,
    with_expected,
)
from excitation_planner.motion import (
    predicted_spectrum,
    PredictedSpectrum,
    sliding_share,
    Trajectory,
    whiteness,
)
from excitation_planner.plan import ExcitationPlan, rounded, sealed
from excitation_planner.pose_range import actual_change, largest_change
from excitation_planner.remedies import with_cures
from excitation_planner.request import PlanRequest
from excitation_planner.setting import bring_together, Setting, start_of
from excitation_planner.signals import (
    APPROACH,
    AUTOMATIC,
    BAND_LIMITED_NOISE,
    NOISES,
    SLIDING_NOISE,
)
from excitation_planner.ways import plan_approach
from modal_core.channel import SensorLayout
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


def plan_excitation(
    model: FlexibleJointModel,
    layout: SensorLayout | None,
    request: PlanRequest,
    expected: ExpectedModes | None = None,
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
    expected : ExpectedModes or None
        Of a map, at the start; None: what the model has. Noise is strongest where one of them
        would drown, unless the request states a shape.

    Raises
    ------
    PlanError, ModelError, LayoutError
        An unknown joint or link, a pose outside the range, a tolerance that no range meets,
        torques that do not span space, or a limit the motion breaks; each with the numbers.
    """
    if request.signal == APPROACH:
        here = model.check_pose(np.array(request.approach_from, dtype=float))
        limits = plan_limits(model, request)
        return plan_approach(here, start_of(model, request), limits, request.sample_period_s)
    setting = bring_together(model, layout, request)
    if expected is not None:
        setting = exciting(replace(setting, expected=expected), expected)
    if request.signal != AUTOMATIC:
        return _planned(setting)
    try:
        return _planned(_with_signal(setting, SLIDING_NOISE))
    except PlanError as error:
        return _planned(_with_signal(setting, BAND_LIMITED_NOISE), f'no sweeps: {error}')


def _with_signal(setting: Setting, signal: str) -> Setting:
    return replace(setting, request=replace(setting.request, signal=signal))


def _planned(setting: Setting, *notices: str) -> ExcitationPlan:
    """Draw a motion, check it, and seal it."""
    request = setting.request
    drawn = draw_motion(setting)
    trajectory = drawn.trajectory
    acceleration = setting.model.to_controller(trajectory.acceleration)
    spectrum = predicted_spectrum(acceleration, trajectory.sample_period_s)
    projection = projection_of(setting, trajectory, spectrum)
    if request.require_full_rank:
        require_full_rank(projection)
    envelope = check_limits(trajectory, plan_limits(setting.model, request))
    # Samples round off the corners of a pulse; who plays it does not.
    peaks = np.maximum(envelope.peak_acceleration, drawn.peak_acceleration)
    envelope = replace(envelope, peak_acceleration=peaks)
    told = (*notices, *drawn.notices)
    return _sealed_plan(setting, trajectory, spectrum, projection, envelope, told)


def projection_of(
    setting: Setting, trajectory: Trajectory, spectrum: PredictedSpectrum
) -> TorqueProjection:
    """Return the torque projection where on the path it is weakest, in the band of interest."""
    request = setting.request
    rms = spectrum.rms((request.band_low_hz, request.band_high_hz))
    return projection_along(setting.model, trajectory.position, rms)


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
        guided=request.signal in NOISES,
    )


def forecast_modes(
    setting: Setting, spectrum: PredictedSpectrum, duration_s: float
) -> tuple[ModeForecast, ...]:
    """Predict how every mode up to the highest frequency of interest will show."""
    request = setting.request
    modes = mode_participation(
        setting.model, setting.start, setting.channels, request.band_high_hz
    )
    if setting.expected is not None:
        modes = with_expected(modes, setting.expected)
    edge_hz = analysed_hz(request.signal, request.band_high_hz)
    return forecast(modes, spectrum, request.noise_density**2, duration_s, edge_hz)


def _sealed_plan(
    setting: Setting,
    trajectory: Trajectory,
    spectrum: PredictedSpectrum,
    projection: TorqueProjection,
    envelope: Envelope,
    notices: tuple[str, ...],
) -> ExcitationPlan:
    request, model = setting.request, setting.model
    band_hz = _excited_band_hz(spectrum, request)
    modes = forecast_modes(setting, spectrum, trajectory.duration_s)
    modes = with_cures(modes, setting, trajectory.duration_s)
    changes = _largest_changes(setting, trajectory)
    if request.enforce_tolerance and np.any(changes > request.frequency_tolerance):
        raise _too_wide(modes, changes, request)
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
            mode_frequency_hz=rounded([mode.frequency_hz for mode in modes]),
            mode_frequency_sensitivity=rounded(changes),
            mode_signal_to_noise_db=rounded([mode.signal_to_noise_db for mode in modes]),
            sample_period_s=trajectory.sample_period_s,
            position=trajectory.position,
            velocity=trajectory.velocity,
            prediction=_prediction(
                setting, trajectory, spectrum, projection, modes, envelope, notices
            ),
        )
    )


def _excited_band_hz(spectrum: PredictedSpectrum, request: PlanRequest) -> tuple[float, float]:
    """Return the excited band; of noise, wherever its sweeps are stronger, that of the noise."""
    if request.signal not in NOISES:
        return spectrum.excited_band_hz()
    return spectrum.excited_band_hz((request.band_low_hz, request.band_high_hz))


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
    setting: Setting,
    trajectory: Trajectory,
    spectrum: PredictedSpectrum,
    projection: TorqueProjection,
    modes: tuple[ModeForecast, ...],
    envelope: Envelope,
    notices: tuple[str, ...],
) -> PlanPrediction:
    band_hz, model = _excited_band_hz(spectrum, setting.request), setting.model
    acceleration = model.to_controller(trajectory.acceleration)
    position = model.to_controller(trajectory.position)
    share = sliding_share(position, trajectory.sample_period_s, setting.request.presliding_rad)
    missed = (
        f'mode at {mode.frequency_hz:.2f} Hz would be missed: {mode.reason}; {mode.cure}'
        for mode in modes
        if mode.missed
    )
    weak = () if projection.rank == 3 else (projection.reason,)
    return PlanPrediction(
        spectrum=spectrum,
        whiteness=tuple(
            whiteness(column, trajectory.sample_period_s, band_hz) if np.any(column) else None
            for column in acceleration.T
        ),
        flatness_db=spectrum.flatness_db(band_hz),
        projection=projection,
        modes=modes,
        envelope=envelope,
        sliding_share=tuple(float(part) for part in share),
        notices=(*notices, *missed, *weak),
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
