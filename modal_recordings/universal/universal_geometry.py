"""Nodes and lines that other programs wrote into universal files: datasets 15, 2411 and 82."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_recordings.universal.universal_blocks import blocks_of
from modal_recordings.universal.universal_file import datasets, metres_per_length, UNITS

NODES, LINES = (15, 2411), 82
OWN_AXES = (18, 2420)
"""Coordinate systems: directions of nodes that use them are none of the file's own axes."""
PEN_UP = 0
"""The number of no node: dataset 82 begins a new line there."""


@dataclass(frozen=True, slots=True)
class UniversalGeometry:
    """A wireframe of numbered nodes.

    Parameters
    ----------
    numbers : tuple of int
        Of the nodes.
    points_m : (n_nodes, 3) array [m]
        Their places.
    lines : tuple of tuple of int
        Polylines through nodes, by number.
    """

    numbers: tuple[int, ...]
    points_m: NDArray[np.float64]
    lines: tuple[tuple[int, ...], ...] = ()


def read_geometry(path: Path) -> UniversalGeometry | None:
    """Return the nodes and lines; None where there are none, or nodes have axes of their own.

    Raises
    ------
    RecordingError
        Truncated, damaged, or no universal file.
    """
    if any(block.kind in OWN_AXES for block in blocks_of(path)):
        return None
    sets = datasets(path, (*NODES, LINES, UNITS))
    nodes = [each for each in sets if each['type'] in NODES]
    if not nodes:
        return None
    try:
        places = {number: place for each in nodes for number, place in _places(each)}
        factor = next((metres_per_length(path, s) for s in sets if s['type'] == UNITS), 1.0)
        points_m = factor * np.array(list(places.values()))
        lines = [line for each in sets if each['type'] == LINES for line in _lines(each['nodes'])]
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise RecordingError('no geometry that can be read', where=path, found=error) from error
    unknown = next((number for line in lines for number in line if number not in places), None)
    if unknown is not None or not np.isfinite(points_m).all():
        raise RecordingError('a line through no node', where=path, found=unknown)
    return UniversalGeometry(tuple(places), points_m, tuple(lines))


def _places(content: Mapping[str, Any]) -> list[tuple[int, tuple[float, float, float]]]:
    columns = [np.atleast_1d(content[name]) for name in ('node_nums', 'x', 'y', 'z')]
    return [(int(n), (float(x), float(y), float(z))) for n, x, y, z in zip(*columns, strict=True)]


def _lines(nodes: Sequence[float]) -> list[tuple[int, ...]]:
    """Return polylines; a node 0 lifts the pen."""
    found: list[list[int]] = [[]]
    for number in np.atleast_1d(nodes).astype(int).tolist():
        if number == PEN_UP:
            found.append([])
        else:
            found[-1].append(number)
    return [tuple(line) for line in found if len(line) > 1]
