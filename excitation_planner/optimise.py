"""Choose amplitudes, pauses, pulse shapes and joint weights so that the worst mode is known best.

The measure is the mode whose expected standard deviation is largest in its own natural unit: of
the natural frequency over the half-power bandwidth ζf, and of the damping ratio over itself.  The
search is random first and local then, seeded, and every winner is a whole plan that keeps the
tolerance and all limits.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from excitation_planner.bounds import check_limits
from excitation_planner.drawing import draw_motion, find_allowed_range
from excitation_planner.forecast import ModeForecast, require_full_rank
from excitation_planner.motion import predicted_spectrum
from excitation_planner.planner import forecast_modes, plan_excitation, plan_limits, projection_of
from excitation_planner.request import PlanRequest
from excitation_planner.setting import bring_together, Setting
from excitation_planner.signals import BAND_LIMITED_NOISE, RANDOM_PULSES
from modal_core.channel import SensorLayout
from modal_core.errors import PlanError
from modal_core.work.progress import Progress
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Shortest build-up of acceleration that keeps the jerk limit with room for the spline.
JERK_ROOM = 1.2
SHAPE_KNOTS = 6
LOCAL_SHARE = 0.6
LOCAL_WIDTH = 0.15


@dataclass(frozen=True, slots=True)
class Optimised:
    """The outcome of a search.

    Parameters
    ----------
    request : PlanRequest
        The best request; ``plan_excitation`` makes its plan.
    worst_std, baseline_worst_std : float
        Worst expected standard deviation in natural units, of the best request and of the one the
        search began with; infinite where a limit refuses the plan.
    worst_frequency_hz : float [Hz]
        The mode that limits the best request.
    n_tried, n_refused : int
        Requests looked at, and those a limit refused.
    """

    request: PlanRequest
    worst_std: float
    baseline_worst_std: float
    worst_frequency_hz: float
    n_tried: int
    n_refused: int


def uniform_intervals(request: PlanRequest) -> PlanRequest:
    """Return the request with the paper's pulses: one shape, pauses of 0 to 1 s, axes alike."""
    return replace(
        request,
        signal=RANDOM_PULSES,
        joint_weights=request.joint_weights or (1.0,),
        require_full_rank=False,
        interval_low_s=0.0,
        interval_high_s=1.0,
        acceleration_low=request.acceleration_high,
        ramp_high_s=request.ramp_low_s,
        speed_low=request.speed_high,
    )


def worst_mode(modes: tuple[ModeForecast, ...], band_hz: tuple[float, float]) -> ModeForecast:
    """Return the mode in the band that would be known worst.

    Raises
    ------
    PlanError
        The model has no mode in the band.
    """
    inside = [mode for mode in modes if band_hz[0] <= mode.frequency_hz <= band_hz[1]]
    if not inside:
        raise PlanError(
            'no mode to plan for',
            where='band of interest',
            found=f'{band_hz[0]:g} to {band_hz[1]:g} Hz',
        )
    return max(inside, key=natural_std)


def natural_std(mode: ModeForecast) -> float:
    """Return a mode's larger expected σ: of f over ζf, of ζ over ζ."""
    return max(
        mode.frequency_std_hz / (mode.damping_ratio * mode.frequency_hz),
        mode.damping_ratio_std / mode.damping_ratio,
    )


def optimise(
    model: FlexibleJointModel,
    layout: SensorLayout,
    request: PlanRequest,
    n_trials: int = 80,
    progress: Progress | None = None,
) -> Optimised:
    """Search for a better request of the same duration, band, range and tolerance.

    Parameters
    ----------
    model, layout, request
        As for ``plan_excitation``; the request is the baseline.
    n_trials : int
        Requests to look at.
    progress : callable or None
        Told the part done.

    Raises
    ------
    PlanError
        The baseline has no mode in its band, or nothing keeps the limits.
    """
    setting = bring_together(model, layout, request)
    fixed = _with_range(setting)
    baseline = _tried(model, layout, fixed)
    generator = np.random.default_rng([request.seed, 2])
    best, best_point = baseline, None
    n_refused = 0
    for trial in range(n_trials):
        point = _propose(best_point, trial, n_trials, _n_numbers(setting), generator)
        found = _tried(model, layout, _request_at(setting, fixed, point), to_beat=best.worst_std)
        n_refused += not np.isfinite(found.worst_std)
        if found.worst_std < best.worst_std:
            best, best_point = found, point
        if progress is not None:
            progress((trial + 1) / n_trials)
    if not np.isfinite(best.worst_std):
        raise PlanError(
            'no request keeps every limit', where='optimise', found=f'{n_trials} tried'
        )
    chosen = replace(
        best.request, enforce_tolerance=request.enforce_tolerance, signal=request.signal
    )
    plan_excitation(model, layout, chosen)
    return Optimised(
        request=chosen,
        worst_std=best.worst_std,
        baseline_worst_std=baseline.worst_std,
        worst_frequency_hz=best.worst_frequency_hz,
        n_tried=n_trials + 1,
        n_refused=n_refused,
    )


@dataclass(frozen=True, slots=True)
class _Trial:
    request: PlanRequest
    worst_std: float
    worst_frequency_hz: float


def _tried(
    model: FlexibleJointModel,
    layout: SensorLayout,
    request: PlanRequest,
    to_beat: float = float('inf'),
) -> _Trial:
    """Look at one request; a limit it breaks makes it infinitely bad.

    The limits, the slow part, are looked at only when the request would be the new best.
    """
    setting = bring_together(model, layout, request)
    refused = _Trial(request, float('inf'), float('nan'))
    try:
        trajectory = draw_motion(setting).trajectory
    except PlanError:
        return refused
    acceleration = model.to_controller(trajectory.acceleration)
    spectrum = predicted_spectrum(acceleration, trajectory.sample_period_s)
    modes = forecast_modes(setting, spectrum, trajectory.duration_s)
    mode = worst_mode(modes, (request.band_low_hz, request.band_high_hz))
    if natural_std(mode) >= to_beat:
        return _Trial(request, natural_std(mode), mode.frequency_hz)
    try:
        if request.require_full_rank:
            require_full_rank(projection_of(setting, trajectory, spectrum))
        check_limits(trajectory, plan_limits(model, request))
    except PlanError:
        return refused
    return _Trial(request, natural_std(mode), mode.frequency_hz)


def _with_range(setting: Setting) -> PlanRequest:
    """Settle the range of pulses once: finding it is the slow part of a plan."""
    request = setting.request
    if request.signal != RANDOM_PULSES:
        # Sweeps change no mode's signal to noise: the winner is planned with them.
        return replace(request, signal=BAND_LIMITED_NOISE)
    if request.half_range == 0.0:
        half_range = float(np.max(find_allowed_range(setting).half_range))
        request = replace(request, half_range=half_range)
    # The range has been proven (or waived); the final plan checks the tolerance again.
    return replace(request, enforce_tolerance=False)


def _n_numbers(setting: Setting) -> int:
    n_moving = int(np.count_nonzero(setting.weights))
    return n_moving + (1 + SHAPE_KNOTS if _guided(setting) else 6)


def _guided(setting: Setting) -> bool:
    return setting.request.signal != RANDOM_PULSES


def _propose(
    best: Array | None, trial: int, n_trials: int, size: int, generator: np.random.Generator
) -> Array:
    """Return a point of the unit cube: anywhere at first, then near the best."""
    if best is None or trial < (1.0 - LOCAL_SHARE) * n_trials:
        return generator.random(size)
    step = LOCAL_WIDTH * generator.standard_normal(size) * (generator.random(size) < 0.5)
    return np.asarray(np.clip(best + step, 0.0, 1.0))


def _request_at(setting: Setting, fixed: PlanRequest, point: Array) -> PlanRequest:
    """Turn a point of the unit cube into a request."""
    moving = np.flatnonzero(setting.weights)
    names = tuple(setting.model.axis_names[joint] for joint in moving)
    weights = setting.weights[moving] * (0.3 + 0.7 * point[: len(moving)])
    common = {
        'joints': names,
        'joint_weights': tuple(float(w) for w in np.round(weights / np.max(weights), 4)),
    }
    rest = point[len(moving) :]
    changes = (
        _noise_changes(fixed, rest) if _guided(setting) else _pulse_changes(setting, fixed, rest)
    )
    return replace(fixed, **common, **changes)  # type: ignore[arg-type]


def _noise_changes(fixed: PlanRequest, point: Array) -> dict[str, object]:
    knots = np.geomspace(fixed.band_low_hz, fixed.band_high_hz, SHAPE_KNOTS)
    gain = 4.0 ** (2.0 * point[1:] - 1.0)
    return {
        'acceleration_rms': float(np.round(fixed.acceleration_rms * 4.0 ** (point[0] - 0.5), 4)),
        'shape_frequency_hz': tuple(float(f) for f in np.round(knots, 6)),
        'shape_gain': tuple(float(g) for g in np.round(gain, 4)),
    }


def _pulse_changes(setting: Setting, fixed: PlanRequest, point: Array) -> dict[str, object]:
    """Shorter moves, shorter pauses, steeper flanks; the jerk limit ties flank to strength."""
    limits = setting.model.limits
    strength = 0.2 + 0.7 * point[0]
    flank_s = JERK_ROOM * strength * float(np.max(limits.acceleration / limits.jerk))
    if not setting.request.jerk_limited:
        flank_s = 0.0
    reach = 0.1 ** point[3]
    return {
        'acceleration_high': float(np.round(strength, 4)),
        'acceleration_low': float(np.round(max(0.02, strength * (1.0 - 0.7 * point[1])), 4)),
        'ramp_low_s': float(np.round(flank_s, 5)),
        'ramp_high_s': float(np.round(flank_s * (1.0 + 2.0 * point[2]), 5)),
        'half_range': float(np.round(fixed.half_range * reach, 6)),
        'interval_high_s': float(np.round(0.03 * 30.0 ** point[4], 4)),
        'speed_low': float(np.round(0.3 + 0.5 * point[5], 4)),
        'speed_high': 0.9,
    }
