"""A plan as people and programs see it before it is released."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from rich.markup import escape
from rich.table import Table

from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT
from autonomous_modal_analysis.identified.results import plain
from excitation_planner.plan import ExcitationPlan
from excitation_planner.rapid import MOST_OFF, programmed_moves, start_tolerance_deg
from excitation_planner.signals import APPROACH, MOVES
from modal_core.errors import PlanError
from modal_reports import DAMPING, FREQUENCY
from structural_model.description import pose_words, shown
from structural_model.flexible_joint_model import FlexibleJointModel

# What a fine point takes a controller (assumed).
FINE_POINT_S = (0.02, 0.06)
TRAJECTORY = ('position', 'velocity', 'prediction')


def plan_json(plan: ExcitationPlan, model: FlexibleJointModel) -> Mapping[str, object]:
    """Return the figures of a plan for programs; the trajectory itself is left out."""
    names = [name for name in type(plan).__dataclass_fields__ if name not in TRAJECTORY]
    value: dict[str, object] = {name: plain(getattr(plan, name)) for name in names}
    value['start_pose_deg'] = plain(model.shown_axes(plan.start_position))
    value['flange_range_m'] = plain(flange_range(plan, model))
    value['n_samples'] = plan.n_samples
    value['prediction'] = plain(plan.prediction)
    return value


def show_plan(plan: ExcitationPlan, model: FlexibleJointModel) -> None:
    """Print what a person should know before releasing a plan."""
    pose = _pose(model, plan.start_position)
    if plan.signal == APPROACH:
        end = _pose(model, plan.position[-1])
        OUTPUT.print(
            f'approach, {plan.duration_s:g} s from {pose} to {end} (controller axes)',
            markup=False,
        )
    else:
        OUTPUT.print(
            f'{plan.signal.replace("_", " ")}, {plan.duration_s:g} s from {pose}'
            f' (controller axes), {plan.band_low_hz:.1f} to {plan.band_high_hz:.1f} Hz,'
            f' seed {plan.seed}',
            markup=False,
        )
    OUTPUT.print(f'hash {plan.plan_hash}', soft_wrap=True)
    range_mm = ' x '.join(f'{1e3 * way:.2f}' for way in flange_range(plan, model))
    OUTPUT.print(f'the flange stays within {range_mm} mm (x, y, z of the base)')
    OUTPUT.print(
        f'fastest point {1e3 * plan.peak_point_speed:.1f} mm/s,'
        f' torque projection rank {plan.torque_projection_rank}{_weakest(plan)}'
    )
    OUTPUT.print(_joints(plan, model))
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
    reach = shown(np.ptp(model.to_controller(plan.position), axis=0), model.sliding)
    share = plan.prediction.sliding_share
    rows = zip(model.axis_names, share, reach, model.sliding, strict=True)
    words = ', '.join(
        f'{name} {100 * part:.0f} % in {way:.2f} deg'
        if not slides
        else f'{name} {100 * part:.0f} % in {way:.4f} m'
        for name, part, way, slides in rows
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


def _pose(model: FlexibleJointModel, serial: NDArray[np.float64]) -> str:
    return pose_words(shown(model.to_controller(serial), model.sliding) + 0.0, model.sliding)


def _joints(plan: ExcitationPlan, model: FlexibleJointModel) -> Table:
    table = Table()
    unit = '°' if not any(model.sliding) else 'm' if all(model.sliding) else '° or m'
    of_motion = (f'range [{unit}]', f'speed [{unit}/s]', f'acceleration [{unit}/s²]')
    for heading in ('serial joint', *map(escape, of_motion)):
        table.add_column(heading, justify='right')
    rows = zip(
        plan.joint_names,
        model.sliding,
        *(
            shown(values, model.sliding)
            for values in (plan.position_range, plan.peak_velocity, plan.peak_acceleration)
        ),
        strict=True,
    )
    for name, slides, way, speed, acceleration in rows:
        if slides:
            own = f'{way:.5f} m', f'{speed:.4f} m/s', f'{acceleration:.2f} m/s²'
        else:
            own = f'{way:.3f}', f'{speed:.2f}', f'{acceleration:.0f}'
        table.add_row(name, *own)
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
