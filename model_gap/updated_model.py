"""Write the model with the effects that were found, so that every other room can load it."""

import dataclasses
import difflib
from pathlib import Path

import yaml

from modal_core.atomic_file import atomic_path, write_text
from modal_core.channel import SensorLayout
from modal_reports import with_sigma
from model_gap.find_gap import GapResult
from model_gap.gap_json import accepted_effects
from model_gap.hypothesis import corrected_layout
from structural_model import FlexibleJointModel
from structural_model.robot_writer import model_mapping
from structural_model.spec import KnownEffect

NAME, DIFFERENCE, SENSORS = 'model_updated.yaml', 'model_updated.diff', 'sensors.yaml'


def updated_model(result: GapResult) -> FlexibleJointModel:
    """Return the model with the effects' most probable values, tolerances left nominal."""
    search = result.search
    effects = accepted_effects(result)
    if not effects:
        return search.model
    cell = result.final.add_effects(search.nominal.tolerant)
    unchanged = cell.spec is search.scene.cell.spec
    spec = search.model.spec if unchanged else cell.spec
    return dataclasses.replace(
        search.model,
        spec=dataclasses.replace(spec, effects=(*search.model.spec.effects, *effects)),
    )


def updated_layout(result: GapResult) -> SensorLayout:
    """Return the whole sensor layout that was given with the effects of sensors in it."""
    layout = result.search.campaign.whole_layout
    return corrected_layout(layout, result.final) if accepted_effects(result) else layout


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
    write_text(folder / SENSORS, sensors)
    before, after = _text(model_mapping(search.model)), _text(model_mapping(new))
    lines = [f'# + {effect_label(item)}' for item in accepted_effects(result)]
    write_text(folder / NAME, '\n'.join(lines or ['# no effect was added']) + '\n' + after)
    difference = [
        *_difference(before, after, 'model.yaml', NAME),
        *_difference(_text(search.campaign.whole_layout.to_mapping()), sensors, SENSORS, SENSORS),
    ]
    write_text(folder / DIFFERENCE, '\n'.join(difference or ['nothing was changed']) + '\n')
    return folder / NAME


def effect_label(effect: KnownEffect) -> str:
    """Return an effect in one line, numbers with deviation and unit."""
    place = f' at {effect.location}' if effect.location else ''
    variant = f' ({effect.variant})' if effect.variant else ''
    numbers = ', '.join(
        f'{item.name} = {with_sigma(item.value, item.sigma, item.unit)}'
        for item in effect.parameters
    )
    return f'{effect.type}{place}{variant}' + (f': {numbers}' if numbers else '')


def _text(mapping: object) -> str:
    return yaml.safe_dump(
        mapping, sort_keys=False, default_flow_style=None, allow_unicode=True, width=100
    )


def _difference(before: str, after: str, old: str, new: str) -> list[str]:
    return list(
        difflib.unified_diff(before.splitlines(), after.splitlines(), old, new, lineterm='', n=1)
    )
