"""MATLAB and NetCDF files: one array per quantity, one entry per mode."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from autonomous_modal_analysis.export.exported import Exported
from autonomous_modal_analysis.export.netcdf import add_texts, netcdf
from modal_core.mode import MODE_FIELDS


def write_matlab(path: Path, exported: Exported) -> None:
    """Write a MATLAB 5 file: ``frequency_hz``, ``shapes`` (channels x modes), ``channels``, ..."""
    content: dict[str, Any] = dict(_columns(exported))
    content['shapes'] = exported.modes.shapes
    content['shapes_std'] = exported.modes.shapes_std
    content['channels'] = np.array(exported.modes.channel_names, dtype=object)
    content['about'] = dict(exported.about)
    if exported.geometry is not None:
        content['points_m'] = exported.geometry.points_m
        content['displacements'] = np.array(exported.displacements)
    with path.open('wb') as file:
        savemat(file, content, oned_as='column')


def write_netcdf(path: Path, exported: Exported) -> None:
    """Write a NetCDF 3 file with dimensions ``mode`` and ``channel``; complex numbers in parts."""
    with netcdf(path, exported.about) as file:
        file.createDimension('mode', len(exported.modes))
        file.createDimension('channel', len(exported.modes.channel_names))
        units = {item.column: item.unit for item in MODE_FIELDS}
        for name, values in _columns(exported).items():
            variable = file.createVariable(name, 'd', ('mode',))
            variable[:] = values
            variable.units = units[name] or '1'
        for name, shapes in (
            ('shape', exported.modes.shapes),
            ('shape_std', exported.modes.shapes_std),
        ):
            for part, of_part in (('real', shapes.real), ('imag', shapes.imag)):
                variable = file.createVariable(f'{name}_{part}', 'd', ('channel', 'mode'))
                variable[:] = of_part
        add_texts(file, 'channel_name', 'channel', exported.modes.channel_names)


def _columns(exported: Exported) -> dict[str, NDArray[np.float64]]:
    """Return each single number of the modes, (n_modes,)."""
    return {
        item.column: np.array([float(getattr(mode, item.name)) for mode in exported.modes])
        for item in MODE_FIELDS
        if item.single
    }
