"""What the default plan says it will show, and what the emulated arm then shows, in random poses.

The parts are the cell's own (planner, control law, dead time, servo, arm, sensors, identifier),
stepped without a clock: thirty seconds of motion take about five.
`python -m benchmarks.forecast --seeds FIRST END` prints every pose.
"""

import argparse
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
import tempfile

import numpy as np

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.report import match_truth
from benchmarks.table import Line
from modal_core.errors import PlanError
from modal_core.mode import ModeSet
from structural_model import load_layout, load_robot
from structural_model.equations import random_poses
from structural_model.flexible_joint_model import FlexibleJointModel

ROBOT = 'irb6660_205_190'
FIRST_SEED, N_POSES, N_ALL = 7300, 20, 50
HIGHEST_HZ = 60.0
# The range of the default plan lets a natural frequency change by so much; and as everywhere a
# true mode is paired with one of MAC 0.5 or more.
SAME_FREQUENCY = 0.02
REACH_FORECAST, REACH_ALL = 0.95, 0.90


@dataclass(frozen=True)
class Forecast:
    """One true mode below 60 Hz.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Of the model in the pose.
    expected : bool
        The plan says it will show.
    found : bool
        It was identified: one to one, frequency within 2 %, MAC of at least 0.5.
    nearest : str
        The identified mode it was paired with, for people.
    """

    frequency_hz: float
    expected: bool
    found: bool
    nearest: str


@dataclass(frozen=True)
class Pose:
    """What came of one pose; ``refusal`` is the planner's reason, empty when it planned."""

    seed: int
    modes: tuple[Forecast, ...] = ()
    n_found: int = 0
    refusal: str = ''


def rows(n_poses: int) -> Iterator[Line]:
    """Yield the lines."""
    poses = [shown_in(seed) for seed in range(FIRST_SEED, FIRST_SEED + n_poses)]
    played = [pose for pose in poses if not pose.refusal]
    modes = [mode for pose in played for mode in pose.modes]
    expected = [mode for mode in modes if mode.expected]
    part = f'{len(played)} random poses, default plan of 30 s'
    refused = '; '.join(pose.refusal for pose in poses if pose.refusal)
    yield Line(
        'planned, or refused with the reason',
        f'{len(played)} planned, {n_poses - len(played)} refused: {refused or "none"}',
        reach='all',
        met=True,
    )
    for what, chosen, reach in (
        ('modes below 60 Hz that the plan says will show, found', expected, REACH_FORECAST),
        ('of all modes below 60 Hz, found', modes, REACH_ALL),
    ):
        n_found = sum(mode.found for mode in chosen)
        yield Line(
            f'{what}; {part}',
            f'{n_found} of {len(chosen)}',
            ratio=f'{n_found / len(chosen):.3f}',
            reach=f'>= {100 * reach:g} %',
            met=n_found >= reach * len(chosen),
        )
    n_false = sum(pose.n_found - sum(mode.found for mode in pose.modes) for pose in played)
    yield Line(f'modes found that are none of these; {part}', f'{n_false}')


def shown_in(seed: int) -> Pose:
    """Plan, play and identify in a random pose within all ranges."""
    model = load_robot(ROBOT)
    pose = random_poses(model.limits, 1, np.random.default_rng(seed))[0]
    try:
        motion = ama.plan(ROBOT, start_position=[float(angle) for angle in pose], seed=seed)
    except PlanError as error:
        return Pose(seed, refusal=str(error))
    with tempfile.TemporaryDirectory() as folder:
        recording = motion.emulate(Path(folder) / 'played.mcap', {'seed': seed})
        found = recording.identify(robot=ROBOT).modes
    return Pose(seed, _compared(model, pose, motion, found), len(found))


def _compared(
    model: FlexibleJointModel, pose: np.ndarray, motion: ama.PlannedMotion, found: ModeSet
) -> tuple[Forecast, ...]:
    by_name = {channel.name: channel for channel in load_layout(ROBOT).channels}
    true = model.damped_modes(pose, tuple(by_name[name] for name in found.channel_names))
    n_modes = int(np.sum(true.frequency_hz < HIGHEST_HZ))
    pairs = match_truth(
        found, true.frequency_hz[:n_modes], true.damping_ratio[:n_modes],
        true.channel_shapes[:, :n_modes],
    )  # fmt: skip
    expected = [mode for mode in motion.expected_modes if not mode.missed]
    expected_hz = np.array([mode.frequency_hz for mode in expected])
    return tuple(
        Forecast(
            pair.frequency_hz,
            bool(np.any(np.abs(expected_hz / pair.frequency_hz - 1.0) < 1e-2)),
            pair.mode is not None and abs(pair.frequency_error) <= SAME_FREQUENCY,
            'none'
            if pair.mode is None
            else f'{pair.mode.frequency_hz:.2f} Hz, MAC {pair.mac:.2f}',
        )
        for pair in pairs
    )


def _show(poses: Iterable[Pose]) -> None:
    for pose in poses:
        n_found = sum(mode.found for mode in pose.modes)
        print(f'{pose.seed}: {n_found} of {len(pose.modes)}, {pose.n_found} found {pose.refusal}')
        for mode in pose.modes:
            if not mode.found:
                said = 'forecast' if mode.expected else 'not forecast'
                print(f'    {mode.frequency_hz:.2f} Hz ({said}): {mode.nearest}', flush=True)


def main() -> None:
    """Print what came of each pose."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', nargs=2, type=int, default=(FIRST_SEED, FIRST_SEED + N_POSES))
    _show(shown_in(seed) for seed in range(*parser.parse_args().seeds))


if __name__ == '__main__':
    main()
