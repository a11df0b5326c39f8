"""Modes that other programs wrote into universal files: dataset 55, normal and complex."""

from collections.abc import Mapping
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mpc, mpd, normalise
from modal_recordings.universal.universal_file import datasets, DIRECTIONS

SHAPES = 55
NORMAL_MODE, COMPLEX_MODE = 2, 3
METHOD = 'universal file'


def read_shapes(path: Path) -> ModeSet:
    """Return the modes of a universal file by frequency; channels are called ``12:+Z``.

    Directions in which no mode moves a node are left out: a file has all three.

    Raises
    ------
    RecordingError
        Truncated, no universal file, no mode, or modes at different nodes.
    """
    sets = [
        each
        for each in datasets(path, (SHAPES,))
        if each.get('analysis_type') in (NORMAL_MODE, COMPLEX_MODE)
    ]
    if not sets:
        raise RecordingError(
            'no mode', where=path, expected='dataset 55 of a normal or complex mode'
        )
    try:
        nodes = np.asarray(sets[0]['node_nums'], dtype=int)
        if not all(np.array_equal(nodes, np.asarray(each['node_nums'], int)) for each in sets):
            raise RecordingError('modes at different nodes', where=path)
        moved = np.array([_moved(each) for each in sets])
        poles = [_pole(each) for each in sets]
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise RecordingError('no modes that can be read', where=path, found=error) from error
    there = np.any(np.abs(moved) > 0.0, axis=0)
    ways = [DIRECTIONS[number] for number in range(1, moved.shape[2] + 1)]
    names = tuple(
        f'{node}:{way}' for node, row in zip(nodes, there, strict=True)
        for way, is_there in zip(ways, row, strict=True) if is_there
    )  # fmt: skip
    modes = [
        _mode(path, number, pole, shape[there])
        for number, (pole, shape) in enumerate(zip(poles, moved, strict=True), 1)
    ]
    return ModeSet(tuple(sorted(modes, key=lambda mode: mode.frequency_hz)), names, METHOD)


def _moved(content: Mapping[str, Any]) -> NDArray[np.complex128]:
    """Return how a mode moves each node, (n_nodes, 3 or 6)."""
    n = int(content['n_data_per_node'])
    columns = [np.asarray(content[f'r{number}'], dtype=complex) for number in range(1, n + 1)]
    found = np.stack(columns, axis=1)
    if found.shape[0] != len(content['node_nums']) or not 1 <= n <= 6:
        raise ValueError(f'{found.shape[0]} values of {len(content["node_nums"])} nodes')
    return found


def _pole(content: Mapping[str, Any]) -> complex:
    """Return the pole with positive imaginary part [rad/s]."""
    if content['analysis_type'] == COMPLEX_MODE:
        pole = complex(content['eig'])
        return complex(pole.real, abs(pole.imag))
    omega, zeta = 2.0 * math.pi * float(content['freq']), float(content['modal_damp_vis'])
    return omega * complex(-zeta, math.sqrt(max(1.0 - zeta**2, 0.0)))


def _mode(path: Path, number: int, pole: complex, shape: NDArray[np.complex128]) -> Mode:
    size = abs(pole)
    if not (0.0 < size < math.inf and -pole.real / size <= 1.0 and np.isfinite(shape).all()):
        raise RecordingError('no mode', where=f'{path}: mode {number}', found=f'pole {pole:.4g}')
    made = normalise(shape) if np.any(shape) else shape
    return Mode(
        frequency_hz=size / (2.0 * math.pi),
        damping_ratio=max(-pole.real / size, 0.0),
        shape=made,
        mpc=float(np.squeeze(mpc(made))),
        mpd=float(np.squeeze(mpd(made))),
        id=number,
    )
