"""Samples of a recording in files of other programs: responses over time on one uniform clock."""

from collections.abc import Callable, Mapping
import csv
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from autonomous_modal_analysis.export.netcdf import netcdf
from autonomous_modal_analysis.export.table import Table
from autonomous_modal_analysis.export.table_files import write_parquet
from autonomous_modal_analysis.export.universal import ascii_line, places_of, SI, write_sets
from autonomous_modal_analysis.export.write_by_ending import write_by_ending
from modal_recordings.universal import KINDS

TIME_RESPONSE, EVEN, TIME_AXIS = 1, 1, 17


@dataclass(frozen=True)
class ExportedSamples:
    """Responses on one clock.

    Parameters
    ----------
    values : (n_samples, n_channels) array [SI units]
        All finite.
    sample_rate_hz : float [Hz]
        Of the rows.
    names, units : tuple of str
        Of the columns.
    about : mapping of str to str
        Name, version of the software and the like.
    """

    values: NDArray[np.float64]
    sample_rate_hz: float
    names: tuple[str, ...]
    units: tuple[str, ...]
    about: Mapping[str, str] = field(default_factory=dict)

    @property
    def time_s(self) -> NDArray[np.float64]:
        """Time of each row from the first [s]."""
        return np.arange(len(self.values)) / self.sample_rate_hz

    @property
    def columns(self) -> dict[str, NDArray[np.float64]]:
        """The time and every channel, by name with its unit."""
        both = zip(self.names, self.units, strict=True)
        named = {f'{name} [{unit}]': self.values[:, n] for n, (name, unit) in enumerate(both)}
        return {'time [s]': self.time_s, **named}


def export_samples(path: Path, exported: ExportedSamples) -> None:
    """Write samples into a file of the kind its ending says, whole or not at all.

    Raises
    ------
    SettingsError
        No such kind.
    ModalAnalysisError
        A library that it needs is not installed.
    OSError
        It cannot be written.
    """
    write_by_ending(path, WRITERS, exported)


def _universal(path: Path, exported: ExportedSamples) -> None:
    """Write datasets 58b; a channel that is not called 12:+Z is a node of its own, along X."""
    types = {si: number for number, si in KINDS.items()}
    step_s = 1.0 / exported.sample_rate_hz
    sets: list[dict[str, Any]] = [SI]
    places = places_of(exported.names)
    for column, (name, unit) in enumerate(zip(exported.names, exported.units, strict=True)):
        node, way = places[column]
        axis = int(np.argmax(np.abs(way)))
        sets.append({
            **{'type': 58, 'binary': 1, 'func_type': TIME_RESPONSE, 'ref_node': 0, 'ref_dir': 0},
            **{'rsp_node': node, 'rsp_dir': int(way[axis]) * (axis + 1), 'rsp_ent_name': 'NONE'},
            **{'id1': ascii_line(name), 'id2': ascii_line(', '.join(exported.about.values()))},
            **{'data': exported.values[:, column], 'x': exported.time_s},
            **{'num_pts': len(exported.values), 'abscissa_spacing': EVEN, 'abscissa_min': 0.0},
            **{'abscissa_inc': step_s, 'abscissa_spec_data_type': TIME_AXIS},
            **{'abscissa_axis_lab': 'Time', 'abscissa_axis_units_lab': 's'},
            **{'ordinate_spec_data_type': types.get(unit, 0), 'ordinate_axis_units_lab': unit},
            'orddenom_spec_data_type': 0,
        })  # fmt: skip
    write_sets(path, sets)


def _matlab(path: Path, exported: ExportedSamples) -> None:
    one = set(exported.units)
    with path.open('wb') as file:
        content = {
            'samples': exported.values,
            'fs': exported.sample_rate_hz,
            'channels': np.array(exported.names, dtype=object),
            'units': np.array(exported.units, dtype=object),
            **({'unit': one.pop()} if len(one) == 1 else {}),
            'about': dict(exported.about),
        }
        savemat(file, content, oned_as='column')


def _netcdf(path: Path, exported: ExportedSamples) -> None:
    """Write a NetCDF 3 file: a variable a channel, over ``time``."""
    with netcdf(path, exported.about) as file:
        file.createDimension('time', len(exported.values))
        columns = [('time', 's', exported.time_s)]
        for column, (name, unit) in enumerate(zip(exported.names, exported.units, strict=True)):
            columns.append((name.replace('/', '_'), unit, exported.values[:, column]))
        for name, unit, values in columns:
            variable = file.createVariable(name, 'd', ('time',))
            variable[:] = values
            variable.units = unit


def _csv(path: Path, exported: ExportedSamples) -> None:
    with path.open('w', encoding='utf-8', newline='') as file:
        csv.writer(file, lineterminator='\n').writerow(exported.columns)
        np.savetxt(file, np.column_stack(list(exported.columns.values())), '%.12g', ',')


def _parquet(path: Path, exported: ExportedSamples) -> None:
    write_parquet(path, Table.of(exported.columns, exported.about))


WRITERS: dict[str, Callable[[Path, ExportedSamples], None]] = {
    '.uff': _universal,
    '.unv': _universal,
    '.mat': _matlab,
    '.nc': _netcdf,
    '.parquet': _parquet,
    '.csv': _csv,
}
