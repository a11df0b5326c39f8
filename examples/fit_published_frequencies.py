"""Fit a robot's stiffnesses to published frequencies and write them into its model.yaml.

Usage: python examples/fit_published_frequencies.py config/robots/irb6660_205_190
The robot's fit.yaml says what is free; the seed in it makes the result reproducible.
"""

import dataclasses
from pathlib import Path
import sys

import numpy as np

from modal_core.files.atomic_file import write_text
from modal_core.files.yaml_file import load_yaml
from structural_model import load_robot
from structural_model.description import BaseSpec, LinkSpec, ModelSpec, Spring
from structural_model.fitting import (
    FitProblem,
    FitResult,
    FreeParameter,
    FrequencyFit,
    PoseTarget,
)

PARTS = {
    'drive': ('drive.spring',),
    'tilts': ('tilts.0', 'tilts.1'),
    'tilt_1': ('tilts.0',),
    'tilt_2': ('tilts.1',),
}
BEGIN, END = '# --- fitted: begin ---', '# --- fitted: end ---'


def free_parameter(entry: dict) -> FreeParameter:
    """Return the parameter an entry of fit.yaml stands for."""
    if 'joint' in entry:
        stem = f'joints.{entry["joint"]}.'
        parts = PARTS[entry['part']]
        name = f'{entry["joint"]}.{entry["part"]}'
        targets = tuple(f'{stem}{part}.stiffness' for part in parts)
    elif 'base' in entry:
        name, targets = 'base.rotation', tuple(f'base.springs.{n}.stiffness' for n in (3, 4, 5))
    elif 'mass' in entry:
        name, targets = f'{entry["mass"]}.mass', (f'masses.{entry["mass"]}.mass_kg',)
    else:
        name, targets = f'{entry["link"]}.mass_factor', (f'links.{entry["link"]}.mass_factor',)
    return FreeParameter(
        name, targets, float(entry['low']), float(entry['high']), str(entry['source'])
    )


def read_problem(data: dict) -> FitProblem:
    """Return the problem fit.yaml describes."""
    return FitProblem(
        parameters=tuple(free_parameter(entry) for entry in data['parameters']),
        targets=tuple(
            PoseTarget(
                pose=entry['pose'],
                frequency_hz=tuple(entry['frequency_hz']),
                candidates=tuple(tuple(modes) for modes in entry['candidates']),
                lowest_hz=float(entry['lowest_hz']),
            )
            for entry in data['targets']
        ),
        frequency_sd=float(data['frequency_sd']),
        starts=int(data['starts']),
    )


def with_link_factors(spec: ModelSpec, links: list[str]) -> ModelSpec:
    """Give every fitted link a neutral correction and the base its springs."""
    floor = tuple(Spring(value) for value in (1e9, 1e9, 2e9, 1.5e8, 1.5e8, 1.5e8))
    return dataclasses.replace(
        spec, links=tuple(LinkSpec(link) for link in links), base=BaseSpec(floor)
    )


def rounded(value: float) -> str:
    """Return a number with four digits, as YAML reads it."""
    return f'{value:.3e}' if value >= 1e4 else f'{value:.4g}'


def spring(stiffness: float, damping_s: float) -> str:
    """Return a spring in YAML."""
    return f'{{stiffness: {rounded(stiffness)}, damping: {rounded(stiffness * damping_s)}}}'


def fitted_block(result: FitResult, data: dict, joint_numbers: dict) -> str:
    """Return the part of model.yaml the fit writes."""
    values, damping = result.values, data['damping']
    tilt_s = float(damping['tilt_s'])
    lines = [BEGIN, f'# by examples/fit_published_frequencies.py, seed {data["seed"]}', 'joints:']
    for joint, numbers in joint_numbers.items():
        drive = spring(values[f'{joint}.drive'], float(damping['drive_s']))
        tilts = [
            spring(values.get(f'{joint}.{part}', values.get(f'{joint}.tilts')), tilt_s)
            for part in ('tilt_1', 'tilt_2')
        ]
        lines += [
            f'  {joint}:',
            f'    drive: {drive}',
            f'    tilts: [{tilts[0]}, {tilts[1]}]',
            f'    gear_ratio: {numbers.gear_ratio:g}',
            f'    rotor_inertia_kg_m2: {numbers.rotor_inertia_kg_m2:g}',
        ]
    base = [1e9, 1e9, 2e9] + [values['base.rotation']] * 3
    lines += ['base:', '  springs:']
    lines += [f'  - {spring(stiffness, float(damping["base_s"]))}' for stiffness in base]
    lines.append('links:')
    for name, value in values.items():
        if name.endswith('.mass_factor'):
            link = name.split('.')[0]
            lines.append(f'- {{name: {link}, mass_factor: {rounded(value)}}}')
    mass = result.model.spec.masses[0]
    lines += [
        'masses:',
        f'- {{name: {mass.name}, link: {mass.link}, mass_kg: {rounded(mass.mass_kg)}, '
        f'position_m: {list(mass.position_m)}, gyration_m: {list(mass.gyration_m)}}}',
        f'damping: {{mass_proportional_1_s: {float(damping["mass_proportional_1_s"]):g}}}',
        'fit:',
        f'  seed: {data["seed"]}',
        f'  cost: {result.cost:.3f}',
        f'  combinations_determined: {result.rank}',
    ]
    for target in data['targets']:
        pose = target['pose']
        found = result.frequency_hz[pose]
        picked = list(result.modes[pose])
        top = max(target['frequency_hz']) * 1.02
        absent = [n for n in range(len(found)) if n not in picked and found[n] < top]
        lines += [
            f'  {pose}:',
            f'    published_hz: {target["frequency_hz"]}',
            f'    model_hz: {np.round(found[picked], 3).tolist()}',
            f'    residual_percent: {np.round(100 * np.array(result.residual[pose]), 3).tolist()}',
            f'    model_modes: {picked}',
            f'    absent_from_the_paper_hz: {np.round(found[absent], 2).tolist()}',
        ]
    lines.append(
        '  # cost of other readings of which model modes (P1, P3, counted from 0) were published'
    )
    lines.append('  assignments:')
    for tried in result.tried:
        modes = [list(picked) for picked in tried.modes]
        lines.append(f'  - {{modes: {modes}, cost: {tried.cost:.1f}}}')
    lines.append('  parameters:')
    for entry in data['parameters']:
        parameter = free_parameter(entry)
        name = parameter.name
        lines.append(
            f'  - {{name: {name}, value: {rounded(values[name])}, '
            f'range: [{rounded(parameter.low)}, {rounded(parameter.high)}], '
            f'determined: {max(result.determined[name], 0.0):.2f}, source: {parameter.source}}}'
        )
    return '\n'.join([*lines, END])


def main(folder: Path) -> None:
    """Fit one robot."""
    data = load_yaml(folder / 'fit.yaml')
    model = load_robot(folder)
    links = [entry['link'] for entry in data['parameters'] if 'link' in entry]
    start = model.replace(with_link_factors(model.spec, links))
    result = FrequencyFit(start, read_problem(data)).run(
        np.random.default_rng(int(data['seed'])),
        lambda share: print(f'\r{100 * share:3.0f} %', end='', file=sys.stderr),
    )
    text = (folder / 'model.yaml').read_text(encoding='utf-8')
    before, rest = text.split(BEGIN)
    numbers = {joint.name: joint.drive for joint in model.spec.joints}
    block = fitted_block(result, data, numbers)
    write_text(folder / 'model.yaml', before + block + rest.split(END)[1])
    print(f'\n{block}')


if __name__ == '__main__':
    main(Path(sys.argv[1]))
