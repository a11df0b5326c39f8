"""What a campaign records: poses times amplitude levels, each by a plan of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.campaigns.campaign_poses import choose_poses, CREST
from excitation_planner.plan import ExcitationPlan
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from excitation_planner.signals import BAND_LIMITED_NOISE, SLIDING_NOISE
from modal_core.channel import SensorLayout
from modal_core.errors import PlanError, SettingsError
from modal_core.work.progress import Progress
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# The whole of what ``ama gap`` compares, at an amplitude the speed limit allows almost everywhere.
DEFAULTS: Mapping[str, object] = {
    'band_low_hz': 3.0,
    'band_high_hz': 60.0,
    'duration_s': 32.0,
    'acceleration_rms': 1.2,
    # A motion whose every axis is known needs neither directions nor modes to be even.
    'signal': BAND_LIMITED_NOISE,
    'require_full_rank': False,
}
LEVELS = (1.0, 0.35)
# What is asked of the planner when the same pose is recorded standing and running.
STATE_DEFAULTS: Mapping[str, object] = {
    'band_high_hz': 60.0,
    'duration_s': 60.0,
    'sliding_share': 0.95,
    'frequency_tolerance': 0.04,
}
STANDING, RUNNING = 'standing', 'running'
# Of the presliding travel, what noise about a standing joint may use at its peaks (5 %: a Dahl
# friction is then within 3 % of its stiffness at rest), and the peaks over the rms.
STANDING_PART, PEAK = 0.05, 4.0
POSES = 9
SMALLEST_LEVEL, MOST_POSES = 0.02, 100


@dataclass(frozen=True)
class PlannedRecording:
    """One recording to make.

    Parameters
    ----------
    file : str
        Name of the recording.
    pose : (n_joints,) array [rad]
        Serial joints.
    level : float
        Part of the full amplitude.
    request : PlanRequest
        What the planner is asked.
    """

    file: str
    pose: Array
    level: float
    request: PlanRequest

    def plan(self, model: FlexibleJointModel, layout: SensorLayout) -> ExcitationPlan:
        """Make the plan; the same request gives the same plan."""
        return plan_excitation(model, layout, self.request)

    def words(self, model: FlexibleJointModel) -> str:
        """Return file, pose in controller angles, and amplitude, for people."""
        size = f'{self.request.acceleration_rms:.3g} rad/s²'
        axes = model.axes_words(self.pose)
        return f'{self.file}: axes at {axes}, {self.request.duration_s:g} s, {size}'


@dataclass(frozen=True)
class CampaignWish:
    """What a person asks of a campaign.

    Parameters
    ----------
    poses : sequence of (n_joints,) array [rad]
        Serial joints; empty: chosen.
    n_poses : int
        How many are chosen.
    levels : tuple of float
        Amplitudes, parts of the full one; do not count where states are given.
    states : tuple of str
        ``standing`` (noise that leaves the joints stuck), ``running`` (noise on sweeps).
    request : PlanRequest
        Band, length, full amplitude and seed; where the arm starts is overwritten.
    """

    poses: Sequence[Array] = ()
    n_poses: int = POSES
    levels: tuple[float, ...] = LEVELS
    states: tuple[str, ...] = ()
    request: PlanRequest = field(default_factory=lambda: PlanRequest.from_mapping(DEFAULTS))

    def __post_init__(self) -> None:
        """Refuse what no campaign can be."""
        if not 1 <= self.n_poses <= MOST_POSES:
            raise SettingsError(
                'bad number of poses', where='poses', found=self.n_poses, expected='1..100'
            )
        if not set(self.states) <= {STANDING, RUNNING} or len(set(self.states)) < len(self.states):
            raise SettingsError(
                'unknown state, or one named twice',
                where='states',
                found=', '.join(self.states),
                expected=f'{STANDING}, {RUNNING}',
            )
        bad = [level for level in self.levels if not SMALLEST_LEVEL <= level <= 1.0]
        if not self.levels or bad or len(set(self.levels)) != len(self.levels):
            raise SettingsError(
                'bad levels',
                where='levels',
                found=', '.join(f'{level:g}' for level in self.levels) or 'none',
                expected=f'different numbers of {SMALLEST_LEVEL:g}..1, parts of the amplitude',
            )


def planned_recordings(
    model: FlexibleJointModel, layout: SensorLayout, wish: CampaignWish
) -> list[PlannedRecording]:
    """Return the recordings of a campaign, pose after pose, loudest level first.

    All levels of a pose play the same motion, scaled: what is not in proportion then is the arm.

    Raises
    ------
    PlanError, ModelError
        Too few poses, or a pose outside the limits.
    """
    request = _within_accelerations(model, wish.request)
    poses = list(wish.poses) or choose_poses(model, layout, wish.n_poses, request)
    found = []
    for number, pose in enumerate(poses):
        start = tuple(float(angle) for angle in pose)
        there = replace(request, start_position=start, seed=request.seed + number)
        name = f'pose_{number + 1:02d}'
        for state in wish.states:
            own = in_state(there, state)
            level = own.acceleration_rms / request.acceleration_rms
            found.append(PlannedRecording(f'{name}_{state}.mcap', np.asarray(pose), level, own))
        for level in sorted(wish.levels, reverse=True) if not wish.states else ():
            own = replace(there, acceleration_rms=request.acceleration_rms * level)
            file = f'{name}_level_{level:g}.mcap'
            found.append(PlannedRecording(file, np.asarray(pose), level, own))
    return found


def _within_accelerations(model: FlexibleJointModel, request: PlanRequest) -> PlanRequest:
    """Return a request whose slow axes move less, where it leaves open how axes share."""
    most = model.limits.acceleration / CREST
    weights = np.minimum(1.0, most / max(request.acceleration_rms, 1e-12))
    shared = request.joint_weights or request.joints or request.require_full_rank
    if shared or np.all(weights == 1.0):
        return request
    return replace(request, joint_weights=tuple(float(round(x, 4)) for x in weights))


def planned_table(
    model: FlexibleJointModel, planned: Sequence[PlannedRecording]
) -> dict[str, list[object]]:
    """Return one row per recording by column: file, what is played, and where the axes are."""
    requests = [item.request for item in planned]
    angles = [model.shown_axes(item.pose) for item in planned]
    return {
        'file': [item.file for item in planned],
        'level': [item.level for item in planned],
        'signal': [request.signal for request in requests],
        'duration_s': [request.duration_s for request in requests],
        'acceleration_rms_rad_s2': [request.acceleration_rms for request in requests],
        'band_low_hz': [request.band_low_hz for request in requests],
        'band_high_hz': [request.band_high_hz for request in requests],
        'seed': [request.seed for request in requests],
        **{
            f'axis_deg.{name}': [float(each[number]) for each in angles]
            for number, name in enumerate(model.axis_names)
        },
    }


def in_state(request: PlanRequest, state: str) -> PlanRequest:
    """Return a request that leaves joints standing, or lets them run.

    Standing, noise is so weak that it stays inside a small part of the presliding travel: the
    position of white acceleration between f₁ and f₂ has the mean square
    a² (f₁⁻³ - f₂⁻³) / (3 (2π)⁴ (f₂ - f₁)).
    """
    if state == RUNNING:
        return replace(request, signal=SLIDING_NOISE)
    low, high = request.band_low_hz, request.band_high_hz
    square = (low**-3 - high**-3) / (3.0 * (2.0 * np.pi) ** 4 * (high - low))
    most = STANDING_PART * request.presliding_rad / (PEAK * np.sqrt(square))
    rms = min(request.acceleration_rms, float(np.round(most, 6)))
    return replace(request, signal=BAND_LIMITED_NOISE, acceleration_rms=rms)


def check_all(
    model: FlexibleJointModel,
    layout: SensorLayout,
    planned: Sequence[PlannedRecording],
    progress: Progress = lambda _: None,
) -> None:
    """Plan the loudest motion of every pose before anything moves.

    Raises
    ------
    PlanError
        The limit that would be broken, and at which pose.
    """
    loudest = {(item.pose.tobytes(), item.request.signal): item for item in reversed(planned)}
    for number, item in enumerate(loudest.values()):
        try:
            item.plan(model, layout)
            progress((number + 1) / len(loudest))
        except PlanError as error:
            raise PlanError(
                f'no plan at the pose {model.axes_words(item.pose)}: {error.what}',
                where=error.where,
                found=error.found,
                expected=error.expected,
                advice='lower acceleration_rms in --request, or name other poses',
            ) from error
