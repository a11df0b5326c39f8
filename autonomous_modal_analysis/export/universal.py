"""Universal files: nodes (15), lines (82), units (164) and complex modes (55).

References
----------
.. [1] Structural Dynamics Research Laboratory, University of Cincinnati: Universal File Formats
   for Modal Analysis Testing, https://www.ceas3.uc.edu/sdrluff/
"""

from collections.abc import Sequence
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pyuff

from autonomous_modal_analysis.export.exported import Exported
from modal_core.mode import Mode
from modal_recordings.universal import direction_of

LONGEST = 80
Way = tuple[float, float, float]
COMPLEX_MODE, DISPLACEMENT, THREE_DIRECTIONS, COMPLEX = 3, 8, 2, 5
SI = {
    **{'type': 164, 'units_code': 1, 'units_description': 'SI: Meter (newton)', 'temp_mode': 1},
    **{'length': 1.0, 'force': 1.0, 'temp': 1.0, 'temp_offset': 273.15},
}


def write_universal(path: Path, exported: Exported) -> None:
    """Write the modes; where no place is known, the n-th channel is node n, moved along X.

    Channels that measure no motion along a direction are left out beside those that do: a node has
    no place for them.
    """
    sets: list[dict[str, Any]] = [SI]
    if exported.geometry is not None:
        points_m = exported.geometry.points_m
        nodes = np.array(exported.geometry.numbers or range(1, len(points_m) + 1))
        sets.append({'type': 15, 'node_nums': nodes, **dict(zip('xyz', points_m.T, strict=True))})
        sets += [
            {'type': 82, 'trace_num': number, 'nodes': nodes[list(line)]}
            for number, line in enumerate(exported.geometry.lines, start=1)
            if len(line) > 1
        ]
        moved = list(exported.displacements)
    else:
        names = exported.modes.channel_names
        straight = [row for row, name in enumerate(names) if name not in exported.others]
        rows = straight or [*range(len(names))]
        nodes, places = _nodes([names[row] for row in rows])
        moved = [_at_nodes(mode.shape[rows], len(nodes), places) for mode in exported.modes]
    about = ', '.join(exported.about.values())
    sets += [
        _mode(number, mode, nodes, motion, about)
        for number, (mode, motion) in enumerate(zip(exported.modes, moved, strict=True), start=1)
    ]
    write_sets(path, sets)


def write_sets(path: Path, sets: list[dict[str, Any]]) -> None:
    """Write datasets one by one: the library leaves out the first where it overwrites."""
    pyuff.UFF(str(path)).write_sets(sets, 'add')


def places_of(names: Sequence[str]) -> list[tuple[int, Way]]:
    """Return node and direction of each channel: as the names say (12:+Z), else counted, along X.

    Nodes that files number and our own count are not mixed.
    """
    told = [each for each in map(direction_of, names) if each is not None]
    if len(told) < len(names):
        return [(node, (1.0, 0.0, 0.0)) for node in range(1, len(names) + 1)]
    return told


def _nodes(names: Sequence[str]) -> tuple[NDArray[np.int64], list[tuple[int, int, float]]]:
    """Return the nodes, and for each channel its row, direction and sign."""
    places = places_of(names)
    nodes = sorted({node for node, _ in places})
    ways = [int(np.argmax(np.abs(way))) for _, way in places]
    return np.array(nodes), [
        (nodes.index(node), at, way[at]) for (node, way), at in zip(places, ways, strict=True)
    ]


def _at_nodes(
    shape: NDArray[np.complex128], n_nodes: int, places: list[tuple[int, int, float]]
) -> NDArray[np.complex128]:
    moved = np.zeros((n_nodes, 3), dtype=complex)
    for value, (row, way, sign) in zip(np.nan_to_num(shape), places, strict=True):
        moved[row, way] = sign * value
    return moved


def _mode(
    number: int, mode: Mode, nodes: NDArray[np.int64], moved: NDArray[np.complex128], about: str
) -> dict[str, Any]:
    omega, zeta = 2.0 * math.pi * mode.frequency_hz, mode.damping_ratio
    pole = omega * complex(-zeta, math.sqrt(max(0.0, 1.0 - zeta**2)))
    said = f'Mode {number}: {mode.frequency_hz:.6g} Hz, damping ratio {mode.damping_ratio:.4g}'
    scatter = (
        f'standard deviations {mode.frequency_std_hz:.3g} Hz, {mode.damping_ratio_std:.3g};'
        f' MPC {mode.mpc:.3f}'
    )
    return {
        **{'type': 55, 'analysis_type': COMPLEX_MODE, 'data_ch': THREE_DIRECTIONS},
        **{'spec_data_type': DISPLACEMENT, 'data_type': COMPLEX, 'n_data_per_node': 3},
        **{'id1': said[:LONGEST], 'id2': scatter[:LONGEST], 'id3': ascii_line(about)},
        **{'load_case': 0, 'mode_n': number, 'eig': pole, 'modal_a': 0j, 'modal_b': 0j},
        **{'node_nums': nodes, 'r1': moved[:, 0], 'r2': moved[:, 1], 'r3': moved[:, 2]},
    }


def ascii_line(text: str) -> str:
    """Return text as a line of a universal file holds it."""
    return text.encode('ascii', 'replace').decode()[:LONGEST]
