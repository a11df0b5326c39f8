"""What people see of an identification, and the files it leaves."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.markup import escape

from autonomous_modal_analysis.identification import IdentifiedRecording
from autonomous_modal_analysis.report import (
    Geometry,
    ReportContent,
    Spectrum,
    TrueMode,
    write_report,
)
from autonomous_modal_analysis.results import write_csv, write_json
from autonomous_modal_analysis.terminal import MESSAGES, modes_table, OUTPUT

JSON_NAME, CSV_NAME, REPORT_NAME = 'modes.json', 'modes.csv', 'report.html'


def show_damage(damage: Sequence[str]) -> None:
    """Say on standard error what of a recording could not be read."""
    for statement in damage:
        MESSAGES.print(f'[yellow]damaged[/]: {escape(statement)}', soft_wrap=True)


def show_identification(found: IdentifiedRecording, name: str) -> None:
    """Print the modes of a recording for people."""
    identification = found.identification
    if len(identification.modes):
        OUTPUT.print(modes_table((*identification.modes, *identification.harmonics), name))
    else:
        reason = identification.quality.reason or 'no mode stands out of the noise'
        OUTPUT.print(f'no modes: {escape(reason)}')
    identified = sum(1 for window in identification.windows if len(window.modes))
    OUTPUT.print(f'{identified} of {len(identification.windows)} windows gave modes')


def write_results(
    folder: Path,
    found: IdentifiedRecording,
    name: str,
    *,
    title: str = 'Operational modal analysis',
    truth: tuple[TrueMode, ...] | None = None,
    geometry: Geometry | None = None,
    displacements: Sequence[NDArray[np.complex128]] = (),
    provenance: Mapping[str, str] | None = None,
) -> None:
    """Write modes.json, modes.csv and report.html into a folder and say so."""
    package = 'autonomous_modal_analysis'
    content = ReportContent(
        title=title,
        recording=name,
        identification=found.identification,
        poles=found.whole.poles,
        spectrum=Spectrum(
            frequency_hz=found.whole.spectrum.frequency_hz,
            singular_value=found.whole.spectrum.singular_value,
        ),
        truth=truth,
        geometry=geometry,
        displacements=tuple(displacements),
        provenance={'software': f'{package} {version(package)}', **(provenance or {})},
    )
    write_json(folder / JSON_NAME, found.identification)
    write_csv(folder / CSV_NAME, found.identification)
    write_report(folder / REPORT_NAME, content)
    MESSAGES.print(f'written: {folder}/{{{JSON_NAME}, {CSV_NAME}, {REPORT_NAME}}}', soft_wrap=True)
