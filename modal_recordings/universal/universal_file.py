"""Universal files (UFF, UNV): time responses of datasets 58 and 58b, units of dataset 164.

References
----------
.. [1] Structural Dynamics Research Laboratory, University of Cincinnati: Universal File Formats
   for Modal Analysis Testing, https://www.ceas3.uc.edu/sdrluff/
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from modal_core.errors import RecordingError
from modal_recordings.disk import check_size
from modal_recordings.formats import NamedArray, NamedArrays
from modal_recordings.tables import row_period_s
from modal_recordings.universal.universal_blocks import Block, blocks_of

FUNCTION, UNITS = 58, 164
TIME_RESPONSE = 1
EVEN = 1
KINDS = {8: 'm', 11: 'm/s', 12: 'm/s^2', 9: 'N', 13: 'N', 15: 'Pa', 5: 'degC'}
"""SI unit of a specific data type of an axis."""
ROTATIONS = {'m': 'rad', 'm/s': 'rad/s', 'm/s^2': 'rad/s^2'}
LENGTHS = {1.0: 'm', 1000.0: 'mm', 100.0: 'cm', 39.37008: 'in', 3.28084: 'ft'}
"""Unit of length by the factor of dataset 164, units over metre."""
DIRECTIONS = {1: '+X', -1: '-X', 2: '+Y', -2: '-Y', 3: '+Z', -3: '-Z', 4: '+RX', -4: '-RX',
              5: '+RY', -5: '-RY', 6: '+RZ', -6: '-RZ'}  # fmt: skip
NONE = ('', 'NONE', 'UNKNOWN', 'N/A', 'NULL')
LARGEST_BYTES = 2_000_000_000
"""A file is read whole."""
FUNCTIONS = {0: 'general', 2: 'auto spectrum', 3: 'cross spectrum', 4: 'frequency response',
             6: 'coherence', 7: 'auto correlation', 8: 'cross correlation', 9: 'PSD'}  # fmt: skip


def read(path: Path) -> NamedArrays:
    """Return the time responses of a universal file, called by node and direction: ``12:+Z``.

    Raises
    ------
    RecordingError
        Truncated, no universal file, no time response, or responses whose clocks differ.
    """
    sets = datasets(path, (FUNCTION, UNITS))
    functions = [each for each in sets if each.get('type') == FUNCTION]
    records = [each for each in functions if each.get('func_type') == TIME_RESPONSE]
    if not records:
        kinds = {FUNCTIONS.get(each.get('func_type', -1), 'other') for each in functions}
        raise RecordingError(
            'no time response',
            where=path,
            found=', '.join(sorted(kinds)) or 'no function',
            expected='dataset 58 or 58b with function type 1',
        )
    _check_one_clock(path, records)
    length = next((_length(path, each) for each in sets if each.get('type') == UNITS), 'm')
    names = _names(records)
    return NamedArrays(
        tuple(
            NamedArray(
                name,
                np.asarray(record['data'], dtype=np.float64),
                unit=_unit(record, length),
                headings=(name.rpartition('/')[2],),
                sample_rate_hz=_rate_hz(path, record),
            )
            for name, record in zip(names, records, strict=True)
        )
    )


def datasets(path: Path, kinds: Sequence[int]) -> list[dict[str, Any]]:
    """Read datasets of some kinds one after the other, so that a damaged one is named.

    Raises
    ------
    RecordingError
        Truncated, too large, or no universal file.
    """
    check_size(path, LARGEST_BYTES)
    blocks = blocks_of(path)
    file = pyuff.UFF(str(path))
    if [block.kind for block in blocks] != [int(kind) for kind in file.get_set_types()]:
        raise RecordingError(
            'datasets that cannot be told apart', where=path, found=f'{len(blocks)} datasets'
        )
    found = []
    for block in blocks:
        if block.kind in kinds:
            try:
                found.append(file.read_sets(block.number - 1))
            except Exception as error:  # pyuff raises plain exceptions
                raise _damaged(path, block) from error
            if block.kind == FUNCTION:
                _check_length(path, block, found[-1])
    return found


def _check_length(path: Path, block: Block, content: Mapping[str, Any]) -> None:
    """Refuse a dataset with fewer values than its header announces."""
    stated, there = content.get('num_pts'), len(np.atleast_1d(content.get('data', ())))
    if stated is None or 'data' not in content:
        raise _damaged(path, block)
    if int(stated) != there:
        raise RecordingError(
            'truncated dataset',
            where=f'{path}: dataset {block.number}',
            found=f'{there} values',
            expected=f'{int(stated)}, as its header says',
        )


def _damaged(path: Path, block: Block) -> RecordingError:
    return RecordingError(f'damaged dataset {block.kind}', where=f'{path}: dataset {block.number}')


def _check_one_clock(path: Path, records: Sequence[Mapping[str, Any]]) -> None:
    first, *others = (
        (int(each['num_pts']), float(each.get('abscissa_min', 0.0))) for each in records
    )
    for number, other in enumerate(others, start=2):
        if other != first:
            raise RecordingError(
                'responses of different lengths or starts',
                where=f'{path}: response {number}',
                found=f'{other[0]} samples from {other[1]:g} s',
                expected=f'{first[0]} samples from {first[1]:g} s, as the first has',
            )


def _rate_hz(path: Path, record: Mapping[str, Any]) -> float:
    if int(record.get('abscissa_spacing', EVEN)) == EVEN:
        step_s = float(record.get('abscissa_inc', 0.0))
    else:
        steps = np.diff(np.asarray(record['x'], dtype=float))
        step_s = float(np.median(steps)) if len(steps) else 0.0
        if step_s > 0.0 and np.abs(steps - step_s).max() > 0.5 * step_s:
            raise RecordingError(
                'not sampled evenly', where=path, expected='one time step throughout'
            )
        # Not the median: times of few digits have steps of their own.
        step_s = row_period_s(np.asarray(record['x'], dtype=float)) if len(steps) else 0.0
    if not step_s > 0.0:
        raise RecordingError(
            'no sample rate', where=path, found=f'time step {step_s:g} s', expected='above 0 s'
        )
    return 1.0 / step_s


def _names(records: Sequence[Mapping[str, Any]]) -> list[str]:
    names = []
    for record in records:
        node = str(record.get('rsp_ent_name') or '').strip()
        number = int(record.get('rsp_node', 0))
        place = node if node.upper() not in NONE and not number else str(number)
        direction = DIRECTIONS.get(int(record.get('rsp_dir', 0)), '')
        names.append(f'{place}:{direction}' if direction else place)
    if len(set(names)) == len(names):
        return names
    # Runs one after the other, as long as nobody says that they are not: 2/12:+Z.
    seen: Counter[str] = Counter()
    for row, name in enumerate(names):
        seen[name] += 1
        names[row] = f'{seen[name]}/{name}'
    return names


def _unit(record: Mapping[str, Any], length: str) -> str:
    """Return the unit: as labelled, else by the kind of data in the file's own length."""
    label = str(record.get('ordinate_axis_units_lab') or '').strip()
    if label.upper() not in NONE:
        return label
    si = KINDS.get(int(record.get('ordinate_spec_data_type', 0)), '')
    if abs(int(record.get('rsp_dir', 0))) > 3:
        return ROTATIONS.get(si, si)
    return length + si[1:] if si[:1] == 'm' else si


def _length(path: Path, units: Mapping[str, Any]) -> str:
    factor = float(units.get('length', 1.0))
    for known, name in LENGTHS.items():
        if abs(factor / known - 1.0) < 1e-4:
            return name
    raise RecordingError(
        'unknown unit of length',
        where=f'{path}: dataset 164',
        found=f'{factor:g} of it are a metre',
        expected=', '.join(LENGTHS.values()),
    )


def metres_per_length(path: Path, units: Mapping[str, Any]) -> float:
    """Return the unit of length of a file in metres, as dataset 164 states it.

    Raises
    ------
    RecordingError
        A unit nobody knows.
    """
    name = _length(path, units)
    return next(1.0 / factor for factor, known in LENGTHS.items() if known == name)
