"""How far a measured force moves each mode, for people and as a file."""

from dataclasses import replace
import json
import math
from pathlib import Path

from rich.table import Table

from autonomous_modal_analysis.api.modal_result import ModalResult
from autonomous_modal_analysis.console.terminal import OUTPUT
from autonomous_modal_analysis.identified.measured_force import measured_force
from autonomous_modal_analysis.identified.results import plain
from modal_core.files.atomic_file import write_text
from modal_reports import FREQUENCY
from oma_identifier.known_force import modal_scaling, ModalScaling

FILE = 'modal_masses.json'


def scaling_of(result: ModalResult) -> tuple[ModalScaling, ...]:
    """Return the scale of each mode of a recording with a force.

    Raises
    ------
    ModalAnalysisError
        There is no force.
    """
    if result.source is None or not result.found.parts:
        return ()
    force = measured_force(result.source)
    point = force.name.rpartition('@')[2] if '@' in force.name else None
    found = modal_scaling(force.beside(result.found.parts[0]), result.modes, point)
    if not force.without_unit:
        return found
    nan = math.nan
    return tuple(replace(each, per_force_std=nan, modal_mass_std_kg=nan) for each in found)


def show_scaling(scaling: tuple[ModalScaling, ...]) -> None:
    """Print one row per mode."""
    table = Table(title='what the force moves', title_justify='left')
    for heading in ('Hz', 'ψ/m 1/kg', '± σ', 'modal mass kg', '± σ', 'explained'):
        table.add_column(heading, justify='right')
    for one in scaling:
        known = math.isfinite(one.modal_mass_kg)
        table.add_row(
            FREQUENCY.number(one.frequency_hz, math.nan),
            f'{abs(one.per_force):.3g}',
            f'{one.per_force_std:.2g}' if math.isfinite(one.per_force_std) else '',
            f'{one.modal_mass_kg:.4g}' if known else '',
            f'{one.modal_mass_std_kg:.2g}' if math.isfinite(one.modal_mass_std_kg) else '',
            f'{one.explained:.0%}',
        )
    OUTPUT.print(table)
    if scaling and not any(math.isfinite(one.per_force_std) for one in scaling):
        OUTPUT.print(
            'no unit of force or responses is stated: newtons and m/s² are taken, and what is told'
            ' of masses is as wrong as that is; name the unit of each column',
            soft_wrap=True,
        )
    without = [one.frequency_hz for one in scaling if not math.isfinite(one.modal_mass_kg)]
    if len(without) == len(scaling):
        OUTPUT.print(
            'modal masses need the channel at the force: call its column force@CHANNEL [N]; and a'
            ' force that is not beside a node of the mode',
            soft_wrap=True,
        )
    elif without:
        named = ', '.join(FREQUENCY.number(hz, math.nan) for hz in without)
        OUTPUT.print(
            f'no mass of {named} Hz: the force is beside a node of it, or shape and force do not'
            ' agree about it',
            soft_wrap=True,
        )


def save_scaling(folder: Path, scaling: tuple[ModalScaling, ...]) -> None:
    """Write the same as JSON."""
    content = {
        'modes': [
            {
                'frequency_hz': one.frequency_hz,
                'per_force_real': one.per_force.real,
                'per_force_imag': one.per_force.imag,
                'per_force_std': plain(one.per_force_std),
                'modal_mass_kg': plain(one.modal_mass_kg),
                'modal_mass_std_kg': plain(one.modal_mass_std_kg),
                'explained': one.explained,
            }
            for one in scaling
        ]
    }
    write_text(folder / FILE, json.dumps(content, indent=1) + '\n')
