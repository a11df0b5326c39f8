"""What a model says of one pose, for people."""

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from autonomous_modal_analysis.api.model import ModelAtPose
from autonomous_modal_analysis.console.terminal import OUTPUT
from excitation_planner.pose_range import SensitivityTable
from structural_model.description import pose_words, shown


def show_model(seen: ModelAtPose) -> None:
    """Print one row per mode, with the sensitivity to each joint where asked for."""
    coefficients = seen.sensitivity
    table = Table(box=SIMPLE_HEAD, padding=(0, 0))
    joints = seen.model.joint_names if coefficients is not None else ()
    for heading in ('mode', 'Hz', 'damping %', *joints):
        table.add_column(heading, justify='right', no_wrap=True)
    for number, (frequency_hz, ratio) in enumerate(
        zip(seen.frequencies_hz, seen.damping_ratios, strict=True)
    ):
        table.add_row(
            str(number + 1),
            f'{frequency_hz:.2f}',
            f'{100 * ratio:.2f}',
            *_changes(coefficients, number),
        )
    pose = pose_words(seen.pose_deg, seen.model.sliding)
    OUTPUT.print(f'{seen.model.robot_name} at {pose}{_joints(seen)}', soft_wrap=True, markup=False)
    OUTPUT.print(table)
    if not seen.model.n_dof:
        OUTPUT.print('a rigid model has no modes: springs come from ama gap, or by hand')
    for line in seen.notes:
        OUTPUT.print(f'note: {line}', soft_wrap=True, markup=False)
    if coefficients is not None:
        OUTPUT.print(
            f'change of frequency [%] for a joint step of {seen.step_deg:g} deg:'
            ' from the model at both poses / predicted from the shapes at this one'
        )


def _joints(seen: ModelAtPose) -> str:
    """Tell the serial joints beside the axes where they differ."""
    sliding = seen.model.sliding
    axes, joints = seen.pose_deg.round(2), shown(seen.q, sliding).round(2) + 0.0
    if np.array_equal(axes, joints):
        return ''
    return f' of the controller axes, {pose_words(joints, sliding)} of the serial joints'


def _changes(coefficients: SensitivityTable | None, number: int) -> list[str]:
    if coefficients is None or number >= len(coefficients.actual):
        return []
    pairs = zip(coefficients.actual[number], coefficients.predicted[number], strict=True)
    return [f'{100 * actual:.1f}/{100 * predicted:.1f}' for actual, predicted in pairs]
