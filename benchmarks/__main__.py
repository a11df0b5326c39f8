"""Print our figures beside the peers' and what is to be reached: `python -m benchmarks`.

The quick run takes some minutes; `--full` takes about two hours and says more about chance.
Every group is kept in docs/measured/results, from where the documentation takes its tables.
`python -m benchmarks families --help` says what the random families of structures take.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
import platform
import sys
import warnings

from benchmarks.results import versions, write_lines
from benchmarks.table import HEADER, Line


def speed(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.identifier.speed import rows

    return rows(3, every_repeat=full)


def selection(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.identifier.selection import PRESETS, rows

    return rows(100, 20, PRESETS) if full else rows(10, 2)


def scatter(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.identifier.scatter import CASES, rows, runs

    return rows(runs(100, store=store) if full else runs(10, CASES[:3], store))


def tracking(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.identifier.tracking import rows

    return rows(20 if full else 3)


def throughput(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.identifier.throughput import rows

    return rows(3600, 600.0) if full else rows(240, 600.0)


def streaming(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.identifier.streaming import rows

    return rows(full)


def faults(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.faults.series import rows

    return rows(500)


def emulator(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.emulator import rows

    return rows()


def forecast(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.forecast import N_ALL, N_POSES, rows

    return rows(N_ALL if full else N_POSES)


def states(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.states import rows

    return rows()


def impact(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.impact import rows

    return rows(30 if full else 3)


def modal_map(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.workspace_map.map import N_ARMS, rows

    return rows(4 * N_ARMS if full else N_ARMS)


def lobes(full: bool, store: Path | None) -> Iterator[Line]:
    from benchmarks.workspace_map.lobes import FEW_POINTS, POINTS, rows

    return rows(POINTS if full else FEW_POINTS)


GROUPS: dict[str, Callable[[bool, Path | None], Iterator[Line]]] = {
    'speed': speed,
    'streaming': streaming,
    'selection': selection,
    'scatter': scatter,
    'tracking': tracking,
    'throughput': throughput,
    'emulator': emulator,
    'forecast': forecast,
    'states': states,
    'impact': impact,
    'map': modal_map,
    'lobes': lobes,
    'faults': faults,
}


def main() -> None:
    if sys.argv[1:2] == ['families']:
        from benchmarks.families.__main__ import main as families

        sys.exit(families(sys.argv[2:]))
    if sys.argv[1:2] == ['operation']:
        from benchmarks.operation.__main__ import main as operation

        operation(sys.argv[2:])
        return
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('groups', nargs='*', choices=[*GROUPS, []], help='none: all of them')
    parser.add_argument('--full', action='store_true')
    parser.add_argument('--store', type=Path, help='file that keeps the runs of the scatter')
    arguments = parser.parse_args()
    warnings.simplefilter('ignore')
    print(f'Python {platform.python_version()}, {", ".join(versions())}; one BLAS thread')
    short: list[str] = []
    for name in arguments.groups or GROUPS:
        print(f'\n## {name.capitalize()}\n\n{HEADER}')
        lines = []
        for line in GROUPS[name](arguments.full, arguments.store):
            print(line.markdown(), flush=True)
            lines.append(line)
        short += [line.what for line in lines if line.met is False]
        # Only a whole group is kept: the documentation shows it.
        write_lines(name, lines, (*versions(), 'full' if arguments.full else 'quick run'))
    print(f'\n{len(short)} fall short')
    for what in short:
        print(f'* {what}')


if __name__ == '__main__':
    main()
