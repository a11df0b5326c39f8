"""A plan as people and programs see it before it is released."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from autonomous_modal_analysis.results import plain
from autonomous_modal_analysis.terminal import MESSAGES, OUTPUT
from excitation_planner.plan import ExcitationPlan
from excitation_planner.rapid import MOST_OFF, programmed_moves, start_tolerance_deg
from excitation_planner.signals import APPROACH, MOVES
from modal_core.errors import PlanError
from modal_reports import DAMPING, FREQUENCY
from structural_model.flexible_joint_model import FlexibleJointModel

# What a fine point takes a controller (assumed).
FINE_POINT_S = (0.02, 0.06)
TRAJECTORY = ('position', 'velocity', 'prediction')


def plan_json(plan: ExcitationPlan, model: FlexibleJointModel) -> Mapping[str, object]:
    """Return the figures of a plan for programs; the trajectory itself is left out."""
    names = [name for name in type(plan).__dataclass_fields__ if name not in TRAJECTORY]
    value: dict[str, object] = {name: plain(getattr(plan, name)) for name in names}
    value['start_pose_deg'] = plain(np.rad2deg(model.to_controller(plan.start_position)))
    value['flange_range_m'] = plain(flange_range(plan, model))
    value['n_samples'] = plan.n_samples
    value['prediction'] = plain(plan.prediction)
    return value


def show_plan(plan: ExcitationPlan, model: FlexibleJointModel) -> None:
    """Print what a person should know before releasing a plan."""
    pose = _degrees(model, plan.start_position)
    if plan.signal == APPROACH:
        end = _degrees(model, plan.position[-1])
        OUTPUT.print(f'approach, {plan.duration_s:g} s from {pose} to {end} deg (controller axes)')
    else:
        OUTPUT.print(
            f'{plan.signal.replace("_", " ")}, {plan.duration_s:g} s from {pose} deg'
            f' (controller axes), {plan.band_low_hz:.1f} to {plan.band_high_hz:.1f} Hz,'
            f' seed {plan.seed}'
        )
    OUTPUT.print(f'hash {plan.plan_hash}', soft_wrap=True)
    range_mm = ' x '.join(f'{1e3 * way:.2f}' for way in flange_range(plan, model))
    OUTPUT.print(f'the flange stays within {range_mm} mm (x, y, z of the base)')
    OUTPUT.print(
        f'fastest point {1e3 * plan.peak_point_speed:.1f} mm/s,'
        f' torque projection rank {plan.torque_projection_rank}{_weakest(plan)}'
    )
    OUTPUT.print(_joints(plan))
    _show_sliding(plan, model)
    if plan.signal in MOVES:
        _show_program(plan, model)
    if plan.signal == APPROACH:
        MESSAGES.print('[yellow]note[/]: what stands in the room is not known to the planner')
    if plan.prediction is not None:
        OUTPUT.print(_modes(plan))
        for notice in plan.prediction.notices:
            MESSAGES.print(f'[yellow]note[/]: {notice}', soft_wrap=True)


def flange_range(plan: ExcitationPlan, model: FlexibleJointModel) -> NDArray[np.float64]:
    """Return how far the flange goes along x, y and z of the base, (3,) [m]."""
    return np.asarray(np.ptp(model.frame_positions(plan.position)[:, -1], axis=0))


def _weakest(plan: ExcitationPlan) -> str:
    """Tell how strong the weakest direction is against the strongest."""
    if plan.prediction is None:
        return ''
    return f' (weakest direction {plan.prediction.projection.ratio:.2f} of the strongest)'


def _show_sliding(plan: ExcitationPlan, model: FlexibleJointModel) -> None:
    """Tell how far axes sweep, and what part of the time they slide."""
    if plan.prediction is None:
        return
    reach = np.rad2deg(np.ptp(model.to_controller(plan.position), axis=0))
    rows = zip(model.axis_names, plan.prediction.sliding_share, reach, strict=True)
    words = ', '.join(
        f'{name} {100 * share:.0f} % in {angle:.2f} deg' for name, share, angle in rows
    )
    OUTPUT.print(f'axes slide this part of the time: {words}', soft_wrap=True, markup=False)


def _show_program(plan: ExcitationPlan, model: FlexibleJointModel) -> None:
    """Tell what a program of the controller makes of it."""
    try:
        moves = programmed_moves(plan, model)
    except PlanError as error:
        MESSAGES.print(f'[yellow]note[/]: not for RAPID: {error}', soft_wrap=True, markup=True)
        return
    low_s, high_s = (plan.duration_s + len(moves) * pause_s for pause_s in FINE_POINT_S)
    OUTPUT.print(
        f'as a RAPID program: {len(moves)} moves in {low_s:.0f} to {high_s:.0f} s, each within'
        f' {100 * MOST_OFF:g} % of the plan, from its start +- {start_tolerance_deg(plan):g} deg'
    )


def _degrees(model: FlexibleJointModel, serial: NDArray[np.float64]) -> list[float]:
    angles: list[float] = (np.rad2deg(model.to_controller(serial)).round(2) + 0.0).tolist()
    return angles


def _joints(plan: ExcitationPlan) -> Table:
    table = Table()
    for heading in ('serial joint', 'range [°]', 'speed [°/s]', 'acceleration [°/s²]'):
        table.add_column(heading, justify='right')
    rows = zip(
        plan.joint_names,
        np.rad2deg(plan.position_range),
        np.rad2deg(plan.peak_velocity),
        np.rad2deg(plan.peak_acceleration),
        strict=True,
    )
    for name, angle, speed, acceleration in rows:
        table.add_row(name, f'{angle:.3f}', f'{speed:.2f}', f'{acceleration:.0f}')
    return table


def _modes(plan: ExcitationPlan) -> Table:
    assert plan.prediction is not None  # noqa: S101 - asked by the caller
    table = Table(title='expected modes', title_justify='left')
    for heading in (FREQUENCY.label, DAMPING.label, r'signal/noise \[dB]', 'best sensor', 'seen'):
        table.add_column(heading, justify='right')
    for mode in plan.prediction.modes:
        table.add_row(
            FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz),
            DAMPING.number(mode.damping_ratio, mode.damping_ratio_std),
            f'{mode.signal_to_noise_db:.0f}',
            mode.best_channel,
            f'no: {mode.reason}; {mode.cure}' if mode.missed else 'yes',
        )
    return table
