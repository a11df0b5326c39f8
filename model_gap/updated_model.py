"""Write the model with the effects that were found, so that every other room can load it."""

import dataclasses
import difflib
from pathlib import Path

import yaml

from modal_core.channel import LAYOUT_FILE, SensorLayout
from modal_core.files.atomic_file import atomic_path, write_text
from modal_reports import with_sigma
from model_gap.calibration import tolerances_left
from model_gap.decide import Verdict
from model_gap.find_gap import GapResult
from model_gap.gap_json import accepted_effects
from model_gap.gravity import right_units
from model_gap.hypothesis import corrected_layout
from model_gap.named_at_rest import named_at_rest
from structural_model import FlexibleJointModel
from structural_model.description import KnownEffect
from structural_model.robot_writer import model_mapping

NAME, DIFFERENCE = 'model_updated.yaml', 'model_updated.diff'


def updated_model(result: GapResult) -> FlexibleJointModel:
    """Return the calibrated model with the effects that were accepted.

    What it predicts is what the gap after is of.
    """
    search = result.search
    if result.calibrated is None:
        spec = dataclasses.replace(
            search.model.spec,
            effects=(*search.model.spec.effects, *named_at_rest(result.faults_at_rest, None)),
        )
        return dataclasses.replace(search.model, spec=spec)
    own = dict(search.model.spec.tolerances) | tolerances_left(result)
    spec = dataclasses.replace(
        result.final.cell().spec,
        effects=(*search.model.spec.effects, *accepted_effects(result)),
        tolerances=tuple(own.items()),
    )
    return dataclasses.replace(search.model, spec=spec)


def updated_layout(result: GapResult) -> SensorLayout:
    """Return the whole sensor layout that was given as the campaign tells it."""
    layout = right_units(result.search.campaign.whole_layout, result.faults_at_rest)
    return corrected_layout(layout, result.final) if result.calibrated else layout


def write_updated_model(result: GapResult, folder: Path) -> Path:
    """Write ``model_updated.yaml``, ``robot.urdf``, ``sensors.yaml``, and what was changed.

    Returns
    -------
    Path
        Of the model file; ``load_robot`` and ``load_layout`` take it.
    """
    new, search = updated_model(result), result.search
    with atomic_path(folder / 'robot.urdf') as path:
        path.write_bytes(new.robot.text)
    sensors = _text(updated_layout(result).to_mapping())
    write_text(folder / LAYOUT_FILE, sensors)
    before, after = _text(model_mapping(result.given)), _text(model_mapping(new))
    lines = [f'# + {effect_label(item)}' for item in accepted_effects(result)]
    lines = [*(lines or ['# no effect was added']), f'# {_calibration_said(result)}']
    write_text(folder / NAME, '\n'.join(lines) + '\n' + after)
    given = _text(search.campaign.whole_layout.to_mapping())
    difference = [
        *_difference(before, after, 'model.yaml', NAME),
        *_difference(given, sensors, LAYOUT_FILE, LAYOUT_FILE),
    ]
    write_text(folder / DIFFERENCE, '\n'.join(difference or ['nothing was changed']) + '\n')
    return folder / NAME


def _calibration_said(result: GapResult) -> str:
    if result.calibrated is None:
        return 'not calibrated: what is unexplained would distort its numbers'
    if result.decision.verdict is Verdict.UNEXPLAINED:
        return 'calibrated within its tolerances; what is unexplained may be in its numbers'
    return 'calibrated within its tolerances'


def effect_label(effect: KnownEffect) -> str:
    """Return an effect in one line, numbers with deviation and unit."""
    numbers = ', '.join(
        f'{item.name} = {with_sigma(item.value, item.sigma, item.unit)}'
        for item in effect.parameters
    )
    return f'{effect.type}{effect.where}' + (f': {numbers}' if numbers else '')


def _text(mapping: object) -> str:
    return yaml.safe_dump(
        mapping, sort_keys=False, default_flow_style=None, allow_unicode=True, width=100
    )


def _difference(before: str, after: str, old: str, new: str) -> list[str]:
    return list(
        difflib.unified_diff(before.splitlines(), after.splitlines(), old, new, lineterm='', n=1)
    )
