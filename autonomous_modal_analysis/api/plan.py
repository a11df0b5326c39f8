"""Plan a motion that shakes every mode, and see what it will show before anything moves."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api.modal_plots import new_axes
from autonomous_modal_analysis.api.recording import open_recording, Recording
from autonomous_modal_analysis.api.result import Columns, Result
from autonomous_modal_analysis.api.robot import Layout, read_robot, Robot, sensors_of
from autonomous_modal_analysis.console.terminal import no_progress, ProgressCallback
from autonomous_modal_analysis.pose import parse_pose, PoseGiven
from autonomous_modal_analysis.views.plan_view import plan_json
from excitation_planner.forecast import ModeForecast
from excitation_planner.plan import ExcitationPlan
from excitation_planner.planner import plan_excitation
from excitation_planner.rapid import rapid_module
from excitation_planner.rapid_options import RapidOptions
from excitation_planner.request import PlanRequest
from modal_core.channel import SensorLayout
from modal_core.errors import ModelError, SettingsError
from modal_core.files.atomic_file import write_text
from modal_core.settings.schema import read_values
from modal_reports import DAMPING, FREQUENCY
from modal_reports.palette import on_white
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
ROBOT = 'irb6660_205_190'


@dataclass(frozen=True, eq=False, repr=False)
class PlannedMotion(Result):
    """A plan, and what it is expected to show.

    Parameters
    ----------
    plan : ExcitationPlan
        Frozen, seeded, hashed: what a person releases is what is played.
    model : FlexibleJointModel
        The robot.
    robot : str, path or FlexibleJointModel
        As it was named.
    """

    plan: ExcitationPlan
    model: FlexibleJointModel
    robot: Robot

    @property
    def plan_hash(self) -> str:
        """What an operator releases; the same request gives the same."""
        return self.plan.plan_hash

    @property
    def time_s(self) -> Array:
        """Times of the samples of the trajectory, (n_samples,) [s]."""
        return np.asarray(np.arange(self.plan.n_samples) * self.plan.sample_period_s)

    @property
    def position(self) -> Array:
        """Serial joint angles, (n_samples, n_joints) [rad]."""
        return self.plan.position

    @property
    def velocity(self) -> Array:
        """Serial joint speeds, (n_samples, n_joints) [rad/s]."""
        return self.plan.velocity

    @property
    def expected_modes(self) -> tuple[ModeForecast, ...]:
        """Modes of the model, with what the plan would show of each; none for an approach."""
        return () if self.plan.prediction is None else self.plan.prediction.modes

    @property
    def notices(self) -> tuple[str, ...]:
        """What a person should know before releasing the plan."""
        return () if self.plan.prediction is None else self.plan.prediction.notices

    def headline(self) -> str:
        """Say what moves for how long, and how many modes would show."""
        plan, modes = self.plan, self.expected_modes
        seen = sum(not mode.missed for mode in modes)
        return (
            f'{plan.robot_name}: {plan.signal.replace("_", " ")}, {plan.duration_s:g} s, '
            f'{plan.band_low_hz:.1f} to {plan.band_high_hz:.1f} Hz, seed {plan.seed}, '
            f'hash {plan.plan_hash[:12]}; {seen} of {len(modes)} modes would show'
        )

    def columns(self) -> Columns:
        """Return the expected modes; σ is the smallest any unbiased method can reach."""
        modes = self.expected_modes
        names = [item.name for item in fields(ModeForecast) if item.name != 'joint_share']
        return {
            **{name: [getattr(mode, name) for mode in modes] for name in names},
            'missed': [mode.missed for mode in modes],
        }

    def shown(self) -> Columns:
        """Return the expected modes as texts."""
        modes = self.expected_modes
        return {
            FREQUENCY.label: [FREQUENCY.number(m.frequency_hz, m.frequency_std_hz) for m in modes],
            DAMPING.label: [DAMPING.number(m.damping_ratio, m.damping_ratio_std) for m in modes],
            'signal/noise [dB]': [f'{mode.signal_to_noise_db:.0f}' for mode in modes],
            'best sensor': [mode.best_channel for mode in modes],
            'seen': [f'no: {mode.reason}' if mode.missed else 'yes' for mode in modes],
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama plan --json`` prints; the trajectory is left out."""
        return dict(plan_json(self.plan, self.model))

    def save_rapid(self, path: str | Path, options: RapidOptions | None = None) -> None:
        """Write the plan as a RAPID module to load by hand.

        Parameters
        ----------
        path : path
            Of the module.
        options : RapidOptions or None
            What the controller it is for has, and calls things.

        Raises
        ------
        PlanError
            No program of the controller can make the motion.
        OSError
            The file cannot be written.
        """
        write_text(Path(path), rapid_module(self.plan, self.model, options))

    def emulate(
        self,
        path: str | Path,
        arm: Mapping[str, object] | None = None,
        progress: ProgressCallback = no_progress,
    ) -> Recording:
        """Play the plan on the emulated controller and arm, as fast as it goes, and record it.

        Parameters
        ----------
        path : path
            MCAP file to write.
        arm : mapping or None
            What is hidden in the arm and its sensors: ``seed``, ``effects``, ``tolerance``, ... as
            ``ama campaign --arm`` reads it; None: as the model says.
        progress : callable
            Told the fraction done, 0..1.

        Returns
        -------
        Recording

        Raises
        ------
        ModalAnalysisError
            An option is wrong, the controller stopped the motion, or the robot is not given by
            name or folder.
        """
        from abb_emulator.run_plan import ArmOptions
        from autonomous_modal_analysis.campaigns.emulated_player import EmulatedPlayer

        if not isinstance(self.robot, str | Path):
            raise ModelError(
                'the emulated arm is made from the files of a robot',
                where='robot',
                found=self.model.robot_name,
                expected='its name or folder',
            )
        options = ArmOptions.from_mapping({**(arm or {}), 'robot': str(self.robot)})
        EmulatedPlayer(options).play(self.plan, Path(path), progress)
        return open_recording(path)

    def plot_trajectory(self, ax: Any = None) -> Any:
        """Draw how far each joint turns from its start.

        Parameters
        ----------
        ax : matplotlib Axes or None
            Where to; None: a new figure.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        ModalAnalysisError
            matplotlib is not installed.
        """
        ax = new_axes(ax)
        turned_deg = np.rad2deg(self.position - self.plan.start_position)
        for name, column in zip(self.plan.joint_names, turned_deg.T, strict=True):
            ax.plot(self.time_s, column, lw=0.8, label=name)
        ax.set_xlabel('time [s]')
        ax.set_ylabel('turned from the start [deg]')
        ax.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize='small')
        ax.margins(x=0)
        return ax

    def plot_spectrum(self, ax: Any = None) -> Any:
        """Draw the expected density of the joint accelerations, and the modes in it.

        Modes that would be missed are dotted.  Parameters, returns and raises as
        :meth:`plot_trajectory`, and a SettingsError for an approach, which excites nothing.
        """
        if self.plan.prediction is None:
            raise SettingsError('an approach has no spectrum', where='signal', found='approach')
        ax = new_axes(ax)
        spectrum = self.plan.prediction.spectrum
        for name, column in zip(self.model.axis_names, spectrum.density.T, strict=True):
            if column.any():
                ax.semilogy(spectrum.frequency_hz, column, lw=0.8, label=name)
        for mode in self.expected_modes:
            style = ':' if mode.missed else '-'
            ax.axvline(mode.frequency_hz, c=on_white('soft'), lw=0.8, ls=style, alpha=0.7)
        largest = float(spectrum.density.max())
        ax.set_ylim(1e-6 * largest, 3.0 * largest)
        ax.set_xlabel('frequency [Hz]')
        ax.set_ylabel('joint acceleration [(rad/s²)²/Hz]')
        ax.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize='small')
        ax.margins(x=0)
        return ax


def plan(
    robot: Robot = ROBOT,
    pose_deg: PoseGiven = None,
    *,
    serial: bool = False,
    approach_from: PoseGiven = None,
    layout: Layout | None = None,
    request: PlanRequest | None = None,
    **changes: Any,
) -> PlannedMotion:
    """Plan a random motion of all joints that keeps every limit, and forecast what it shows.

    Nothing moves: a plan is played only after a person has released it by its hash.

    Parameters
    ----------
    robot : str, path or FlexibleJointModel
        Robot of config/robots by name, its folder, or its model.yaml.
    pose_deg : str, path, sequence of float [deg] or None
        Where it starts: angles of the controller axes, the name of a pose, or a recording made
        there; None: as in ``request``, else the robot's first.
    serial : bool
        Angles in ``pose_deg`` and ``approach_from`` are those of the serial joints, as in joint
        states; they differ where a rod couples axes.
    approach_from : str, path, sequence of float [deg] or None
        Plan one slow move instead, from here to the start.
    layout : SensorLayout, mapping, path or None
        Sensors that listen; None: the robot's own.
    request : PlanRequest or None
        None: the defaults.
    **changes
        Fields of :class:`excitation_planner.request.PlanRequest`: ``seed``, ``duration_s`` [s],
        ``band_low_hz``, ``band_high_hz`` [Hz], ``acceleration_rms`` [rad/s²], ``signal``, ...

    Returns
    -------
    PlannedMotion

    Raises
    ------
    ModalAnalysisError
        A field is unknown or out of range, there is no such robot or pose, or no motion keeps
        the limits.

    Examples
    --------
    >>> import autonomous_modal_analysis as ama
    >>> motion = ama.plan('irb6660_205_190', 'P1', duration_s=10, seed=3)
    >>> motion.position.shape
    (2501, 6)
    >>> motion.plan_hash == ama.plan('irb6660_205_190', 'P1', duration_s=10, seed=3).plan_hash
    True
    """
    arm = read_robot(robot)
    wish, given = request or PlanRequest(), read_values(PlanRequest, changes)
    stated = wish.start_position or 'start_position' in given
    # Without a pose of any name the planner says what is missing.
    if pose_deg is not None or (arm.poses_controller_rad and not stated):
        given['start_position'] = _angles(arm, pose_deg, serial)
    if approach_from is not None:
        given |= {'signal': 'approach', 'approach_from': _angles(arm, approach_from, serial)}
    sensors = sensors_of(robot, arm, layout) or SensorLayout(())
    return PlannedMotion(plan_excitation(arm, sensors, replace(wish, **given)), arm, robot)


def _angles(arm: FlexibleJointModel, pose_deg: PoseGiven, serial: bool) -> tuple[float, ...]:
    return tuple(float(angle) for angle in parse_pose(arm, pose_deg, serial))
