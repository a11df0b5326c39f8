"""Files of a tap test: modes.json, modes.csv, frf.uff, report.html."""

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from autonomous_modal_analysis.identified.results import file_header, json_text, mode_json, plain
from autonomous_modal_analysis.tap_report.page import render_tap_test
from impact_testing import ImpactResult, TestedPoint
from modal_core.files.atomic_file import atomic_path, write_text

FILES = ('modes.json', 'modes.csv', 'frf.uff', 'report.html')
FORMAT_VERSION = 1
FUNCTION, FREQUENCY_RESPONSE, COMPLEX_DOUBLE = 58, 4, 6
ACCELERATION, FORCE, FREQUENCY = 12, 13, 18
LONGEST_NAME = 10


def tap_test_json(found: ImpactResult) -> dict[str, Any]:
    """Return a tap test as plain values; None where a number is unknown."""
    return {
        'modes': [
            {
                **mode_json(each.mode),
                'modal_mass_kg': plain(each.modal_mass_kg),
                'modal_mass_std_kg': plain(each.modal_mass_std_kg),
            }
            for each in found.scaled_modes
        ],
        'shape_channels': list(found.places),
        'band_hz': list(found.band_hz),
        'segment_s': found.length_s,
        'misfit': plain(found.misfit),
        'points': [_point_json(point) for point in found.points],
        'driving_phase_deg': plain(found.driving_phase_deg),
        'reciprocity': plain(found.reciprocity),
        'remarks': list(found.remarks),
    }


def save_tap_test(folder: Path, found: ImpactResult, name: str) -> None:
    """Write the files of a tap test into a folder, each whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    file = file_header(FORMAT_VERSION, recording=name)
    write_text(folder / FILES[0], json_text({'file': file, **tap_test_json(found)}))
    write_text(folder / FILES[1], _csv_text(found))
    with atomic_path(folder / FILES[2]) as temporary:
        _write_frfs(temporary, found)
    write_text(folder / FILES[3], render_tap_test(found, name))


def _point_json(point: TestedPoint) -> dict[str, Any]:
    taps = [
        {
            'recording': recording,
            'time_s': time_s,
            'peak_n': each.tap.peak_n,
            'width_s': each.tap.width_s,
            'good': each.good,
            'faults': {str(fault): how for fault, how in each.faults},
        }
        for recording, _, time_s, each in point.told_taps()
    ]
    names = point.data.frf.spectra.names
    agreement = dict(zip(names, point.agreement.tolist(), strict=True))
    return {'name': point.name, 'hit': point.hit, 'taps': plain(taps), 'frac': plain(agreement)}


def _csv_text(found: ImpactResult) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    parts = [f'{part}.{name}' for name in found.places for part in ('shape_real', 'shape_imag')]
    own = ('frequency_hz', 'frequency_std_hz', 'damping_ratio', 'damping_ratio_std')
    writer.writerow([*own, 'modal_mass_kg', 'modal_mass_std_kg', *parts])
    for each in found.scaled_modes:
        mode = each.mode
        shape = np.column_stack([mode.shape.real, mode.shape.imag]).ravel()
        values = [getattr(mode, name) for name in own]
        row = [*values, each.modal_mass_kg, each.modal_mass_std_kg, *shape]
        writer.writerow(['' if (value := plain(item)) is None else value for item in row])
    return text.getvalue()


def _write_frfs(path: Path, found: ImpactResult) -> None:
    """Write H1 of every channel and point as datasets 58; names stand in the entity fields."""
    sets = [
        _frf_set(number, point, column)
        for number, point in enumerate(found.points, start=1)
        for column in range(len(point.data.frf.spectra.names))
    ]
    pyuff.UFF(str(path)).write_sets(sets, 'add')


def _frf_set(number: int, point: TestedPoint, column: int) -> dict[str, Any]:
    spectra = point.data.frf.spectra
    step, channel = float(spectra.frequency_hz[0]), spectra.names[column]
    made: dict[str, Any] = pyuff.prepare_58(
        binary=0,
        id1=_ascii(f'{channel} over force at {point.hit or point.name}', 80),
        id2=f'H1 of {point.n_good} taps',
        func_type=FREQUENCY_RESPONSE,
        rsp_ent_name=_ascii(channel, LONGEST_NAME),
        rsp_node=column + 1,
        rsp_dir=1,
        ref_ent_name=_ascii(point.hit or 'NONE', LONGEST_NAME),
        ref_node=number,
        ref_dir=1,
        ord_data_type=COMPLEX_DOUBLE,
        abscissa_spacing=1,
        abscissa_min=step,
        abscissa_inc=step,
        num_pts=len(spectra.frequency_hz),
        abscissa_spec_data_type=FREQUENCY,
        abscissa_axis_units_lab='Hz',
        ordinate_spec_data_type=ACCELERATION,
        ordinate_axis_units_lab='m/s^2',
        orddenom_spec_data_type=FORCE,
        orddenom_axis_units_lab='N',
        x=spectra.frequency_hz,
        data=point.data.frf.h1[:, column],
        return_full_dict=True,
    )
    return {key: _stated(key, value) for key, value in made.items()}


def _stated(key: str, value: Any) -> Any:
    """Return what the library writes for a field that nobody stated."""
    if value is not None:
        return value
    return 'NONE' if key.startswith('id') or key.endswith(('_lab', '_name')) else 0


def _ascii(text: str, longest: int) -> str:
    return text.encode('ascii', 'replace').decode()[:longest]
