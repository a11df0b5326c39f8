"""The motions of a map: chosen, planned and checked before the first, bound by one hash.

What a pose will tell does not hang on what is measured there, so that the whole series stands
beforehand and a person releases it once.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.campaigns.campaign_poses import choose_poses, is_possible
from excitation_planner.plan import ExcitationPlan
from excitation_planner.planner import plan_excitation, plan_limits
from excitation_planner.request import PlanRequest
from excitation_planner.ways import PART_OF_SPEED, plan_approach
from modal_core.channel import SensorLayout
from modal_core.errors import PlanError, SettingsError
from modal_core.files.atomic_file import write_text
from modal_core.files.json_file import load_json
from modal_core.settings.schema import check_settings, setting
from modal_core.work.progress import Progress
from structural_model.equations import random_poses
from structural_model.flexible_joint_model import FlexibleJointModel
from workspace_map import (
    candidates,
    choose_series,
    layout_fingerprint,
    model_fingerprint,
    WorkspaceMap,
)

Array = NDArray[np.float64]
CANDIDATES, OF_INTEREST, ON_THE_WAY = 48, 80, 40
"""Poses that may be measured, poses whose frequencies count, poses checked between two."""
SHORTEST_S, LONGEST_S = 20.0, 120.0
LARGEST_BYTES = 1_000_000
REST_S = 2.0
"""At rest before and after a motion, recorded too."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapWish:
    """What a person asks of a map."""

    poses: int = setting(12, 'poses to measure at most', 2, 48)
    accuracy: float = setting(
        0.005, 'σ over value that 90 % of the frequencies of the workspace shall have', 1e-4, 0.2
    )
    budget_s: float = setting(1200.0, 'time of the arm, motion and records [s]', 60.0, 86400.0)
    record_s: float | None = setting(
        None, 'length of each record [s]', 10.0, 600.0, automatic='what the accuracy needs'
    )
    highest_hz: float = setting(60.0, 'modes below it are mapped [Hz]', 5.0, 500.0)
    seed: int = setting(1, 'seed of poses and motions', 0, 2**31 - 1)

    def __post_init__(self) -> None:
        """Check every field."""
        check_settings(self)


@dataclass(frozen=True, slots=True)
class Stop:
    """One pose of a series.

    Parameters
    ----------
    pose_rad : tuple of float [rad]
        Where the excitation starts, serial joints.
    plan_hash : str
        Of the excitation.
    way_hash : str
        Of the way there from the pose before; empty: the first, which a person brings the arm to.
    way_s, record_s : float [s]
        Time of the way and of the record.
    """

    pose_rad: tuple[float, ...]
    plan_hash: str
    way_hash: str
    way_s: float
    record_s: float

    @property
    def seconds(self) -> float:
        """Time of the arm [s]."""
        return self.way_s + self.record_s


@dataclass(frozen=True)
class Series:
    """All motions of a map, each bound by its hash; made anew when they are played.

    Parameters
    ----------
    asked : str
        Fingerprint of what it was planned for.
    duration_s : float [s]
        Of each excitation.
    stops : tuple of Stop
        In order.
    """

    asked: str
    duration_s: float
    stops: tuple[Stop, ...]

    @property
    def series_hash(self) -> str:
        """What a person releases: it binds every motion and their order."""
        hashes = [each for stop in self.stops for each in (stop.way_hash, stop.plan_hash)]
        return sha256(' '.join((self.asked, *hashes)).encode()).hexdigest()

    @property
    def seconds(self) -> float:
        """Time of the arm [s]."""
        return sum(stop.seconds for stop in self.stops)

    def excitation(
        self, model: FlexibleJointModel, layout: SensorLayout, wish: MapWish, stop: Stop
    ) -> ExcitationPlan:
        """Return the motion of a stop.

        Raises
        ------
        PlanError
            It is not the one that was released.
        """
        request = replace(request_of(wish, self.duration_s), start_position=stop.pose_rad)
        plan = plan_excitation(model, layout, request)
        if plan.plan_hash != stop.plan_hash:
            raise PlanError(
                'not the motion that was released', where=f'pose {self.stops.index(stop) + 1}',
                advice='plan and release the series anew, in another folder',
            )  # fmt: skip
        return plan

    def way(
        self, model: FlexibleJointModel, layout: SensorLayout, wish: MapWish, number: int
    ) -> ExcitationPlan:
        """Return the way to a stop from the one before.

        Raises
        ------
        PlanError
            It is not the one that was released.
        """
        before, there = (
            self.excitation(model, layout, wish, self.stops[at]) for at in (number - 1, number)
        )
        request = request_of(wish, self.duration_s)
        start, end = before.position[-1], there.start_position
        plan = plan_way(model, request, start, end, there.sample_period_s)
        if plan.plan_hash != self.stops[number].way_hash:
            raise PlanError(
                'not the way that was released', where=f'pose {number + 1}',
                advice='plan and release the series anew, in another folder',
            )  # fmt: skip
        return plan

    def save(self, path: Path) -> None:
        """Write the series, whole or not at all."""
        write_text(path, json.dumps(asdict(self), indent=1) + '\n')

    @classmethod
    def load(cls, path: Path) -> 'Series':
        """Read a series.

        Raises
        ------
        SettingsError
            It is none.
        """
        data = load_json(path, LARGEST_BYTES)
        try:
            stops = tuple(
                Stop(**{**each, 'pose_rad': tuple(each['pose_rad'])}) for each in data['stops']
            )
            return cls(str(data['asked']), float(data['duration_s']), stops)
        except (KeyError, TypeError, ValueError) as error:
            raise SettingsError('no series of motions', where=path, found=repr(error)) from error


def asked_of(known: WorkspaceMap, layout: SensorLayout, wish: MapWish) -> str:
    """Return the fingerprint of what a series is planned for."""
    parts = (
        model_fingerprint(known.arm.model),
        layout_fingerprint(layout),
        repr(known.arm.tool),
        repr(wish),
        '' if known.before is None else repr([p.plan_hash for p in known.before.measured]),
    )
    return sha256('\n'.join(parts).encode()).hexdigest()[:16]


def request_of(wish: MapWish, duration_s: float) -> PlanRequest:
    """Return what the planner is asked at every pose, but for the pose."""
    return PlanRequest(
        seed=wish.seed,
        duration_s=duration_s,
        band_low_hz=3.0,
        band_high_hz=wish.highest_hz,
        require_full_rank=False,
    )


def record_length(known: WorkspaceMap, wish: MapWish) -> float:
    """Return the record that tells every mode of the model to half the accuracy, [s].

    Twice the least σ of log f, sqrt(ζ/(2πfT)), shall be half of what is wanted of the map.
    """
    if wish.record_s is not None:
        return wish.record_s
    model = known.arm.model
    named = [model.pose(name) for name in model.poses_controller_rad]
    modes = [model.modes(pose) for pose in named or [model.usual_pose()]]
    worst = max(
        float(
            np.max((each.damping_ratio / each.frequency_hz)[each.frequency_hz < wish.highest_hz])
        )
        for each in modes
    )
    wanted = 16.0 * worst / (2.0 * np.pi * wish.accuracy**2)
    return float(np.clip(np.ceil(wanted), SHORTEST_S, LONGEST_S))


def plan_series(
    model: FlexibleJointModel,
    layout: SensorLayout,
    known: WorkspaceMap,
    wish: MapWish,
    progress: Progress = lambda _: None,
) -> Series:
    """Choose poses, plan all motions and check them against every limit.

    Parameters
    ----------
    model, layout
        The robot and its sensors.
    known : WorkspaceMap
        What is known already: nothing, or the map of another arm.
    wish : MapWish
        What is asked.
    progress : callable
        Takes the fraction done.

    Raises
    ------
    PlanError
        Too few poses, or a limit that no motion keeps.
    """
    request = request_of(wish, record_length(known, wish))
    possible = np.array(choose_poses(model, layout, CANDIDATES, request))
    interest = random_poses(model.limits, OF_INTEREST, np.random.default_rng([wish.seed, 7]))
    choice = candidates(known, possible, interest, request.duration_s)
    planner = _Planner(model, layout, request)
    out: set[int] = set()
    while len(out) <= len(possible) - wish.poses:
        times = _times(model, request, out, possible)
        order = choose_series(known, choice, wish.poses, times)
        stops, failed = planner.stops(possible, order, wish.budget_s, progress)
        if failed is None:
            return Series(asked_of(known, layout, wish), request.duration_s, tuple(stops))
        out.add(failed)
    raise PlanError(
        'too few poses that can be reached and shaken', found=len(possible) - len(out),
        expected=wish.poses, advice='ask for fewer',
    )  # fmt: skip


def way_seconds(
    model: FlexibleJointModel, request: PlanRequest, start: Array, end: Array
) -> float:
    """Return about how long an approach takes: its longest path of a point at its speed, [s]."""
    part = np.linspace(0.0, 1.0, ON_THE_WAY // 2)[:, None]
    points = model.frame_positions(start + part * (end - start))
    length = np.linalg.norm(np.diff(points, axis=0), axis=2).sum(axis=0).max()
    return float(length / (PART_OF_SPEED * request.point_speed_m_s))


def _times(
    model: FlexibleJointModel, request: PlanRequest, out: set[int], possible: Array
) -> Callable[[Array | None, Array], Array]:
    def seconds(here: Array | None, to: Array) -> Array:
        way = [0.0 if here is None else way_seconds(model, request, here, q) for q in to]
        found = np.array(way) + request.duration_s + REST_S
        found[list(out)] = np.inf
        return found

    return seconds


@dataclass
class _Planner:
    """Plans motions, each once."""

    model: FlexibleJointModel
    layout: SensorLayout
    request: PlanRequest

    def __post_init__(self) -> None:
        self._made: dict[bytes, ExcitationPlan] = {}

    def stops(
        self, possible: Array, order: list[int], budget_s: float, progress: Progress
    ) -> tuple[list[Stop], int | None]:
        """Return the stops that the budget allows, or the pose that cannot be one."""
        stops: list[Stop] = []
        before: ExcitationPlan | None = None
        for number, each in enumerate(order):
            try:
                plan = self._excitation(possible[each])
                way = None if before is None else self._approach(before, plan)
            except PlanError:
                return stops, each
            start = tuple(float(angle) for angle in possible[each])
            own = (way.plan_hash, way.duration_s) if way else ('', 0.0)
            stop = Stop(start, plan.plan_hash, *own, plan.duration_s + REST_S)
            if sum(stop.seconds for stop in (*stops, stop)) > budget_s:
                break
            stops.append(stop)
            before = plan
            progress((number + 1) / len(order))
        return stops, None

    def _excitation(self, q: Array) -> ExcitationPlan:
        key = q.tobytes()
        if key not in self._made:
            there = tuple(float(angle) for angle in q)
            request = replace(self.request, start_position=there)
            self._made[key] = plan_excitation(self.model, self.layout, request)
        return self._made[key]

    def _approach(self, before: ExcitationPlan, to: ExcitationPlan) -> ExcitationPlan:
        start, end = before.position[-1], to.start_position
        return plan_way(self.model, self.request, start, end, to.sample_period_s)


def plan_way(
    model: FlexibleJointModel,
    request: PlanRequest,
    start: Array,
    end: Array,
    sample_period_s: float,
) -> ExcitationPlan:
    """Plan a way from pose to pose, straight in axis angles, clear of the floor and the arm.

    Parameters
    ----------
    model, request
        The robot, and what its motions are planned for.
    start, end : (n_joints,) array [rad]
        Serial joints.
    sample_period_s : float [s]
        Of the trajectory.

    Raises
    ------
    PlanError
        A pose on the way is not possible, or a limit is broken.
    """
    for part in np.linspace(0.0, 1.0, ON_THE_WAY):
        if not is_possible(model, start + part * (end - start), request):
            raise PlanError('the way between two poses is too near to the floor or the arm')
    limits = plan_limits(model, replace(request, signal='band_limited_noise'))
    return plan_approach(start, end, replace(limits, guided=False), sample_period_s)
