"""Plan the next window from what the last one showed; stop when every mode is known well enough.

The worst mode is the one whose standard deviation is farthest above its target.  Its neighbourhood
gets more of the excitation, and the window gets longer, for σ falls with the root of both.
"""

from dataclasses import dataclass, replace
import math

import numpy as np

from excitation_planner.forecast import ExpectedModes
from excitation_planner.motion import LARGEST_GAIN, raised_shape, Stretch
from excitation_planner.plan import ExcitationPlan
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from excitation_planner.signals import NOISES
from modal_core.channel import SensorLayout
from modal_core.errors import PlanError
from modal_core.mode import Mode, ModeSet
from structural_model.flexible_joint_model import FlexibleJointModel

LONGEST_STEP = 2.0
BACK_OFF = 0.8
MOST_TRIES = 8


@dataclass(frozen=True, slots=True)
class Targets:
    """When a mode is known well enough.

    Parameters
    ----------
    frequency_std_ratio : float
        Standard deviation of the natural frequency over the frequency.
    damping_ratio_std_ratio : float
        Standard deviation of the damping ratio over the damping ratio.
    longest_s : float [s]
        No window gets longer.
    """

    frequency_std_ratio: float = 0.002
    damping_ratio_std_ratio: float = 0.1
    longest_s: float = 300.0

    def shortfall(self, mode: Mode) -> float:
        """Return by how much a mode's σ exceeds its target, 1 when just met; ∞ when unknown."""
        ratios = (
            mode.frequency_std_hz / mode.frequency_hz / self.frequency_std_ratio,
            mode.damping_ratio_std / max(mode.damping_ratio, 1e-6) / self.damping_ratio_std_ratio,
        )
        return max(ratio if math.isfinite(ratio) else math.inf for ratio in ratios)


@dataclass(frozen=True, slots=True)
class LoopStep:
    """What to do after a window.

    Parameters
    ----------
    done : bool
        True when all modes in the band meet their targets, or nothing more can be done.
    request : PlanRequest
        For the next window; the last one when done.
    reason : str
        One line for people.
    worst_frequency_hz, worst_shortfall : float [Hz], [-]
        The mode that is worst known; NaN when none was identified.
    """

    done: bool
    request: PlanRequest
    reason: str
    worst_frequency_hz: float = math.nan
    worst_shortfall: float = math.nan


def next_step(request: PlanRequest, modes: ModeSet, targets: Targets) -> LoopStep:
    """Decide from identified modes whether to stop, and what to ask for if not.

    Parameters
    ----------
    request : PlanRequest
        Of the window the modes come from.
    modes : ModeSet
        Identified modes; those outside the band of interest do not count.
    targets : Targets
        When to stop.
    """
    inside = [
        mode
        for mode in modes
        if request.band_low_hz <= mode.frequency_hz <= request.band_high_hz and not mode.harmonic
    ]
    if not inside:
        longer = replace(request, seed=request.seed + 1, duration_s=_longer(request, 4.0, targets))
        return LoopStep(False, longer, 'no mode was identified: a longer window')
    shortfalls = [targets.shortfall(mode) for mode in inside]
    worst = int(np.argmax(shortfalls))
    mode, shortfall = inside[worst], shortfalls[worst]
    known = (
        f'mode at {mode.frequency_hz:.2f} Hz is worst known, σ at {shortfall:.2f} of its target'
    )
    if shortfall <= 1.0:
        return LoopStep(True, request, f'all targets met: {known}', mode.frequency_hz, shortfall)
    following = _following(request, inside, shortfalls, targets)
    if following.duration_s >= targets.longest_s and request.duration_s >= targets.longest_s:
        reason = f'longest window reached: {known}'
        return LoopStep(True, request, reason, mode.frequency_hz, shortfall)
    return LoopStep(False, following, known, mode.frequency_hz, shortfall)


def plan_next(
    model: FlexibleJointModel,
    layout: SensorLayout | None,
    request: PlanRequest,
    expected: ExpectedModes | None = None,
) -> ExcitationPlan:
    """Plan a window whose amplitude may have to give way to the limits.

    A shaped spectrum needs more speed or jerk than a flat one of the same strength, so the
    amplitude asked for is lowered step by step until a whole plan keeps every limit.

    Raises
    ------
    PlanError
        No amplitude helps.
    """
    for _ in range(MOST_TRIES - 1):
        try:
            return plan_excitation(model, layout, request, expected)
        except PlanError:
            request = replace(request, acceleration_rms=BACK_OFF * request.acceleration_rms)
    return plan_excitation(model, layout, request, expected)


def _following(
    request: PlanRequest, modes: list[Mode], shortfalls: list[float], targets: Targets
) -> PlanRequest:
    finite = [min(shortfall, LARGEST_GAIN**2) for shortfall in shortfalls]
    changes: dict[str, object] = {
        'seed': request.seed + 1,
        'duration_s': _longer(request, max(finite), targets),
    }
    if request.signal in NOISES:
        band_hz = request.band_low_hz, request.band_high_hz
        stretches = [
            Stretch(mode.frequency_hz, mode.damping_ratio, shortfall)
            for mode, shortfall in zip(modes, finite, strict=True)
        ]
        shape = raised_shape(band_hz, stretches)
        changes |= {'shape_frequency_hz': shape.frequency_hz, 'shape_gain': shape.gain}
    else:
        # More pulses in the same time bring more energy (Fig. 10 of the paper).
        changes['interval_high_s'] = max(
            request.interval_low_s, 0.1, request.interval_high_s / max(finite)
        )
    return replace(request, **changes)  # type: ignore[arg-type]


def _longer(request: PlanRequest, shortfall: float, targets: Targets) -> float:
    factor = min(LONGEST_STEP, max(1.0, shortfall**2))
    return float(min(request.duration_s * factor, max(targets.longest_s, request.duration_s)))
