"""Write the model with the effects that were found, so that every other room can load it."""

import dataclasses
import difflib
from pathlib import Path

import yaml

from modal_core.atomic_file import atomic_path, write_text
from model_gap.find_gap import GapResult
from model_gap.gap_json import found_effects
from structural_model import FlexibleJointModel
from structural_model.robot_writer import model_mapping

NAME = 'model_updated.yaml'


def updated_model(result: GapResult) -> FlexibleJointModel:
    """Return the model with the effects' most probable values, tolerances left nominal."""
    search = result.search
    setup = result.final.add_effects(search.nominal.tolerant_setup())
    labels = tuple(_label(item) for item in found_effects(result))
    unchanged = setup.spec is search.scene.setup.spec
    spec = search.model.spec if unchanged else setup.spec
    return dataclasses.replace(
        search.model, spec=dataclasses.replace(spec, effects=(*search.model.spec.effects, *labels))
    )


def write_updated_model(result: GapResult, folder: Path) -> Path:
    """Write ``model_updated.yaml`` with ``robot.urdf`` beside it and a readable difference.

    Returns
    -------
    Path
        Of the model file; ``load_robot`` takes it.
    """
    new = updated_model(result)
    with atomic_path(folder / 'robot.urdf') as path:
        path.write_bytes(new.robot.text)
    before, after = _text(result.search.model), _text(new)
    lines = [f'# + {label}' for label in new.spec.effects] or ['# no effect was added']
    write_text(folder / NAME, '\n'.join(lines) + '\n' + after)
    difference = difflib.unified_diff(
        before.splitlines(), after.splitlines(), 'model.yaml', NAME, lineterm='', n=1
    )
    write_text(folder / 'model_updated.diff', '\n'.join(difference) + '\n')
    return folder / NAME


def _text(model: FlexibleJointModel) -> str:
    return yaml.safe_dump(
        model_mapping(model), sort_keys=False, default_flow_style=None, allow_unicode=True
    )


def _label(effect: dict) -> str:  # type: ignore[type-arg]
    place = f' at {effect["location"]}' if effect['location'] else ''
    variant = f' ({effect["variant"]})' if effect['variant'] else ''
    numbers = ', '.join(
        f'{name} = {item["value"]:.4g} ± {item["sigma"]:.2g}'
        + ('' if item['unit'] == '1' else f' {item["unit"]}')
        for name, item in effect['parameters'].items()
    )
    return f'{effect["type"]}{place}{variant}' + (f': {numbers}' if numbers else '')
