"""Running against standing: the shift that is found on an emulated arm whose joints stick.

Each joint has a friction that sticks, a further share of its drive's stiffness, and slips at
0.3 mrad.  Standing, all of it is there; sliding, none; and after each turn of a sweep it sticks
once more.  The same noise is played twice, by ``ama campaign --states standing,running``'s own
requests.  The truth of either state is the arm's with the mean slope of its friction on the way
that was played: what is left of the friction is a part of the running state.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import math
from pathlib import Path
import tempfile

import numpy as np
from scipy.stats import binom

from abb_emulator.mechanics import ArmEffect, with_effects
import autonomous_modal_analysis as ama
from autonomous_modal_analysis.campaigns.campaign_plan import (
    in_state,
    RUNNING,
    STANDING,
    STATE_DEFAULTS,
)
from autonomous_modal_analysis.report import match_truth, TrueMode
from benchmarks.table import Line
from excitation_planner.request import PlanRequest
from structural_model import load_layout, load_robot

ROBOT = 'irb6660_205_190'
SHARES = np.array([0.3, 0.35, 0.3, 0.15, 0.15, 0.15])
SLIPS_RAD = 3e-4
SEED, HIGHEST_HZ = 41, 57.0
# Of Gaussian deviations 95.4 % are within two; fewer than that in 1 % of all runs is no chance.
SIGMAS, INSIDE, CHANCE = 2.0, 0.954, 0.01
POSES = ('P1', 'P2', 'P3')


@dataclass(frozen=True)
class Shift:
    """Of one mode: what it is, what was found, and the standard deviation of that [Hz]."""

    true_hz: float
    found_hz: float
    std_hz: float

    @property
    def within(self) -> bool:
        """The truth is within two of its standard deviations."""
        return abs(self.found_hz - self.true_hz) <= SIGMAS * self.std_hz


def rows() -> Iterator[Line]:
    """Yield the lines, pose by pose."""
    within = n_seen = 0
    for number, pose in enumerate(POSES):
        shifts = shifts_at(pose, SEED + number)
        seen = [shift for shift in shifts if shift is not None]
        n_seen, within = n_seen + len(seen), within + sum(shift.within for shift in seen)
        found = ', '.join(f'{s.found_hz:.2f} ± {s.std_hz:.2f} ({s.true_hz:.2f})' for s in seen)
        yield Line(
            f'running against standing at {pose}, 60 s each, modes seen in both'
            ' states: shift and σ (true shift) in Hz',
            f'{len(seen)} of {len(shifts)}: {found}',
        )
    yield Line(
        f'shifts within 2σ of the truth; {len(POSES)} poses',
        f'{within} of {n_seen}',
        ratio=f'{within / max(n_seen, 1):.3f}',
        reach='95 % but for chance (1 %)',
        met=n_seen > 0 and bool(binom.cdf(within, n_seen, INSIDE) >= CHANCE),
    )


def shifts_at(pose: str, seed: int) -> list[Shift | None]:
    """Return the shift of each mode below 57 Hz; None where one state does not show it."""
    standing, running = (_seen(pose, state, seed) for state in (STANDING, RUNNING))
    return [
        None if still.mode is None or moving.mode is None else _shift(still, moving)
        for still, moving in zip(standing, running, strict=False)
    ]


def friction_slope(path: np.ndarray) -> np.ndarray:
    """Return dz/dx of dz = (1 - sign(dx) z / z_max) dx (Dahl), its mean over a path, by axis.

    Parameters
    ----------
    path : (n_samples, n_joints) array [rad]
        Angles of the controller axes, which their friction works on.
    """
    wound, total = np.zeros(path.shape[1]), np.zeros(path.shape[1])
    for way in np.diff(path, axis=0):
        end = np.sign(way) * SLIPS_RAD
        wound = np.where(way, end - (end - wound) * np.exp(-np.abs(way) / SLIPS_RAD), wound)
        total += 1.0 - np.sign(way) * wound / SLIPS_RAD
    return np.asarray(total / max(len(path) - 1, 1))


def _shift(standing: TrueMode, running: TrueMode) -> Shift:
    still, moving = standing.mode, running.mode
    return Shift(
        standing.frequency_hz - running.frequency_hz,
        still.frequency_hz - moving.frequency_hz,
        math.hypot(still.frequency_std_hz, moving.frequency_std_hz),
    )


def _seen(pose: str, state: str, seed: int) -> tuple[TrueMode, ...]:
    """Play one state on the arm, identify it, and pair what is found with its own truth."""
    model, layout = load_robot(ROBOT), load_layout(ROBOT)
    request = in_state(PlanRequest.from_mapping({**STATE_DEFAULTS, 'seed': seed}), state)
    effects = [
        {'type': 'presliding', 'joint': name, 'share': share, 'limit': SLIPS_RAD}
        for name, share in zip(model.joint_names, SHARES, strict=True)
    ]
    motion = ama.plan(ROBOT, pose, request=request, require_full_rank=False)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f'{state}.mcap'
        found = motion.emulate(file, {'seed': seed, 'effects': effects}).identify(robot=ROBOT)
    path = motion.plan.trajectory.position
    left = SHARES * friction_slope(np.array([model.to_controller(row) for row in path]))
    stiffer = [
        ArmEffect.from_mapping({'type': 'joint_stiffness', 'joint': name, 'factor': 1.0 + more})
        for name, more in zip(model.joint_names, left.tolist(), strict=True)
    ]
    arm = with_effects(model, stiffer, layout.channels)
    by_name = {channel.name: channel for channel in layout.channels}
    true = arm.damped_modes(
        arm.pose(pose), tuple(by_name[name] for name in found.modes.channel_names)
    )
    below = np.flatnonzero(true.frequency_hz < HIGHEST_HZ)
    return match_truth(
        found.modes,
        true.frequency_hz[below],
        true.damping_ratio[below],
        true.channel_shapes[:, below],
    )
