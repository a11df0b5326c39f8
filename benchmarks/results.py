"""Results as files, from which the documentation makes its tables, and whether they are stale.

A file states what measured it: the programs of its group, without their imports and comments.
When these change, the figures are of something else and have to be measured again.
"""

import ast
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
import datetime
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
import json
from pathlib import Path
import platform
from typing import Any

from benchmarks.identifier import peers
from benchmarks.table import Line
from modal_core.files.atomic_file import write_text

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / 'docs' / 'measured' / 'results'
LIBRARIES = ('numpy', 'scipy', *peers.PEERS.values(), 'sdypy-EMA')
COLUMNS = ('what', 'ours', 'peer', 'ratio', 'reach', '')


@dataclass(frozen=True)
class Group:
    """A group of figures.

    Parameters
    ----------
    name : str
        Also of its file.
    programs : tuple of str
        Files or folders that measure it, relative to the root; none: a run by hand, which is
        not repeated by any program.
    command : str
        Measures it anew.
    page : str
        Folder of ``docs`` whose page shows it.
    """

    name: str
    programs: tuple[str, ...]
    command: str
    page: str = 'measured'

    @property
    def path(self) -> Path:
        """Its file of results."""
        measured = self.page == 'measured'
        folder = FOLDER if measured else ROOT / 'docs' / self.page / FOLDER.name
        return folder / f'{self.name}.json'

    @property
    def picture(self) -> Path:
        """Its drawing, where it has one."""
        return self.path.with_suffix('.svg')


PLANT = 'benchmarks/identifier/plant.py'
MAPS = 'benchmarks/workspace_map'


def _group(name: str, *programs: str) -> Group:
    own = programs or (f'benchmarks/{name}.py',)
    return Group(name, (*own, PLANT), f'make bench BENCH={name}')


def _identifier(name: str, *programs: str) -> Group:
    return _group(name, *(f'benchmarks/identifier/{own}.py' for own in (name, *programs)))


def _paper(programs: str, *names: str) -> tuple[Group, ...]:
    """Return the tables and pictures of one finding of the paper; its program stands first."""
    own = tuple(f'examples/paper/{program}.py' for program in (*programs.split(), 'cell'))
    command = f'python -m examples.paper.{programs.split()[0]}'
    return tuple(Group(f'paper_{name}', own, command, 'explanation') for name in names)


MATRIX = 'python -m benchmarks.gap.matrix'
RATES = ('benchmarks/gap/rates.py', 'benchmarks/gap/counts.py', 'benchmarks/gap/multibody')
FINDINGS = tuple(
    f'examples/paper/{program}.py'
    for program in (
        'cell',
        'pulse_spectrum',
        'frequency_responses',
        'sensitivity',
        'batches',
        'self_excitation',
        'all_joints',
        'wide_range',
    )
)
GROUPS = {
    group.name: group
    for group in (
        _identifier('speed', 'cases', 'ours', 'peers', 'record'),
        _identifier('streaming'),
        _identifier('selection'),
        _identifier('scatter'),
        _identifier('tracking'),
        _identifier('throughput'),
        _group('emulator'),
        Group(
            'page',
            ('benchmarks/page.py', 'test/support/page_timing.py'),
            'python -m benchmarks.page',
        ),
        _group('forecast'),
        _group('states'),
        _group('impact'),
        _group('lobes', f'{MAPS}/lobes.py'),
        _group('map', *(f'{MAPS}/{name}.py' for name in ('map', 'hidden_arms', 'rivals'))),
        Group(
            'map_tool',
            (f'{MAPS}/tool.py', f'{MAPS}/hidden_arms.py'),
            'python -m benchmarks.workspace_map.tool',
        ),
        _group('faults', 'benchmarks/faults'),
        Group(
            'families',
            ('benchmarks/families', PLANT, 'benchmarks/identifier/peers.py'),
            'make bench BENCH=families',
        ),
        Group(
            'methods',
            ('benchmarks/methods/__main__.py', 'benchmarks/methods/milled.py', PLANT),
            'python -m benchmarks.methods',
        ),
        Group('operation', ('benchmarks/operation',), 'make bench BENCH=operation'),
        Group(
            'moving',
            ('benchmarks/methods/moving.py', 'benchmarks/methods/milled.py'),
            'python -m benchmarks.methods.moving',
        ),
        Group(
            'ablation',
            ('benchmarks/ablation',),
            'python -m benchmarks.ablation FILE --seeds FIRST END --keep',
        ),
        Group('shapes', (), 'by hand'),
        Group('complex_shapes', (), 'by hand'),
        Group('gap_full_size', (), f'{MATRIX} --first-seed 901 --seeds 2 --table gap_full_size'),
        Group('gap_small', (), f'{MATRIX} --first-seed 900 --quick --table gap_small'),
        Group('gap_outside', (), f'{MATRIX} --only outside --first-seed 903 --table gap_outside'),
        Group('gap_healthy', (), f'{MATRIX} --calibrate 16 --first-seed 2000 --quick'),
        Group('gap_other_simulator', (), 'by hand'),
        Group(
            'gap_at_rest',
            ('benchmarks/gap/at_rest.py', *RATES),
            'python -m benchmarks.gap.at_rest --table',
        ),
        Group('gap_rates', RATES, 'python -m benchmarks.gap.rates --table'),
        Group('gap_single_runs', (), 'by hand'),
        Group(
            'model_speed',
            ('benchmarks/structural_model_speed.py',),
            'python -m benchmarks.structural_model_speed',
            'reference',
        ),
        *_paper('pulse_spectrum', 'pulses', 'arm_pulses', 'pulses_drawn'),
        *_paper('frequency_responses', 'frf', 'frf_drawn', 'frf_postures_drawn'),
        *_paper('sensitivity', 'sensitivity', 'accuracy', 'ranges', 'sensitivity_drawn'),
        *_paper('batches', 'batches', 'shapes_drawn'),
        *_paper('self_excitation', 'p1', 'p3', 'ways', 'self_excitation_drawn'),
        *_paper('all_joints', 'all_joints', 'poles', 'all_joints_drawn'),
        *_paper(
            'wide_range self_excitation sensitivity', 'wide_p1', 'wide_p3', 'wide_range_drawn'
        ),
        *_paper('optimised_pulses', 'optimised'),
        Group('paper_findings', FINDINGS, 'make reproduce', 'explanation'),
    )
}


def definition(group: Group) -> str:
    """Return the fingerprint of what a group measures; empty where no program does."""
    if not group.programs:
        return ''
    seen = sha256()
    for program in group.programs:
        place = ROOT / program
        for path in sorted(place.rglob('*.py')) if place.is_dir() else [place]:
            seen.update(_bare(path.read_text()).encode())
    return seen.hexdigest()[:16]


def _bare(text: str) -> str:
    """Return a program without imports, docstrings and comments: what a move may change.

    Of the text, since the parser's own output differs between versions of Python.
    """
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        said = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if said or isinstance(node, ast.Import | ast.ImportFrom):
            own = range(node.lineno - 1, node.end_lineno or node.lineno)
            lines = ['' if number in own else line for number, line in enumerate(lines)]
    bare = [line.partition('  #')[0].rstrip() for line in lines]
    return '\n'.join(line for line in bare if line and not line.lstrip().startswith('#'))


def write_lines(name: str, lines: Iterable[Line], where: Sequence[str] = ()) -> None:
    """Keep the lines of a group that was measured just now."""
    verdict = {True: 'ok', False: 'short', None: ''}
    rows = [
        [line.what, line.ours, line.peer, line.ratio, line.reach, verdict[line.met]]
        for line in lines
    ]
    write_rows(name, COLUMNS, rows, where)


def write_rows(
    name: str,
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    where: Sequence[str] = (),
) -> None:
    """Keep a table of a group that was measured just now."""
    table = {'columns': list(columns), 'rows': [list(row) for row in rows]}
    _write(GROUPS[name], where, table)


def write_picture(name: str, drawing: str, where: Sequence[str] = ()) -> Path:
    """Keep a drawing (SVG) of a group; its state stands beside it, as that of a table does.

    Returns
    -------
    Path
        The drawing.
    """
    group = GROUPS[name]
    write_text(group.picture, drawing)
    _write(group, where, {'columns': [], 'rows': [], 'picture': fingerprint(group.picture)})
    return group.picture


def fingerprint(path: Path) -> str:
    """Return what tells a file from any other."""
    return sha256(path.read_bytes()).hexdigest()[:16]


def _write(group: Group, where: Sequence[str], content: Mapping[str, Any]) -> None:
    from modal_core.files.version import suite_version

    results: dict[str, Any] = {
        'command': group.command,
        'date': datetime.date.today().isoformat(),
        'version': suite_version(),
        'where': [f'Python {platform.python_version()}', *where],
        'definition': definition(group),
        **content,
    }
    group.path.parent.mkdir(parents=True, exist_ok=True)
    write_text(group.path, json.dumps(results, indent=1, ensure_ascii=False) + '\n')


def versions() -> list[str]:
    """Return the libraries and peers that are compared."""
    found = []
    for name in LIBRARIES:
        try:
            found.append(f'{name} {version(name)}')
        except PackageNotFoundError:
            found.append(f'{name} not installed')
    return found
