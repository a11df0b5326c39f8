"""Print our figures beside the peers' and the targets: `python -m benchmarks [--runs N]`."""

import argparse
from dataclasses import dataclass
import math
from pathlib import Path
import tempfile

from benchmarks import peers, scatter
from benchmarks.cases import write_window
from benchmarks.cost import Cost, measure


@dataclass(frozen=True)
class Row:
    """Ours beside a peer's, with the least ratios of time and memory to reach."""

    what: str
    ours: str
    peer: str
    faster: float
    leaner: float = math.nan


ROWS = (
    Row('SSI-cov, 42 references, poles of all orders', 'ours cov 42', 'pyoma2 cov 42', 10.0, 7.0),
    Row('SSI-cov, 6 references, poles of all orders', 'ours cov 6', 'pyoma2 cov 6', 8.0, 7.0),
    Row("SSI-cov against pyOMA2's cov_R, 42 references", 'ours cov 42', 'pyoma2 cov_R 42', 4.0),
    Row('automatic: bands, poles, selection, σ, spectrum', 'ours automatic', 'pyoma2 std 6', 50.0),
    Row('SSI-data, 42 references', 'ours data 42', 'pyoma2 data 42', 5.0, 5.0),
    Row('SSI-data, 6 references', 'ours data 6', 'pyoma2 data 6', 5.0, 5.0),
    Row('pLSCF, automatic against poles of order 6', 'ours plscf', 'pyoma2 plscf', 5.0, 5.0),
    Row('EFDD', 'ours efdd', 'pyoma2 efdd', 5.0, 5.0),
    Row('SSI-cov against koma', 'ours cov 42', 'koma cov', 10.0),
    Row('refinement of all modes by maximum likelihood', 'ours refine', '', math.nan),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--runs', type=int, default=100, help='Monte Carlo runs per case')
    parser.add_argument('--skip-peers', action='store_true')
    parser.add_argument('--skip-monte-carlo', action='store_true')
    arguments = parser.parse_args()
    if not arguments.skip_peers and peers.missing():
        print(f'Not installed, so left out: {", ".join(peers.missing())}')
    costs(with_peers=not arguments.skip_peers)
    if not arguments.skip_monte_carlo:
        limits(arguments.runs)


def costs(with_peers: bool) -> None:
    print('\n## Cost: 42 channels, 120 s at 512 Hz, one BLAS thread, one process per case\n')
    print('| what | ours CPU s, MB | peer CPU s, MB | faster (reach) | leaner (reach) | notes |')
    print('|---|---|---|---|---|---|')
    known: dict[str, Cost] = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'window.npy'
        write_window(path)
        for row in ROWS:
            for case in (row.ours, row.peer):
                if case and case not in known and (with_peers or case.startswith('ours')):
                    known[case] = _measured(case, path)
            print(_line(row, known), flush=True)


def _measured(case: str, path: Path) -> Cost:
    if not case.startswith('ours') and not peers.installed(case.split()[0]):
        return Cost(error='not installed')
    return measure(case, path)


def _line(row: Row, known: dict[str, Cost]) -> str:
    ours, peer = known[row.ours], known.get(row.peer, Cost(error='-'))
    notes = '; '.join(
        f'{who}: {cost.detail}' for who, cost in (('ours', ours), ('peer', peer)) if cost.detail
    )
    return (
        f'| {row.what} | {_cost(ours)} | {_cost(peer)} '
        f'| {_ratio(peer.cpu_s, ours.cpu_s, row.faster)} '
        f'| {_ratio(peer.peak_mb, ours.peak_mb, row.leaner)} | {notes} |'
    )


def _cost(cost: Cost) -> str:
    return cost.error or f'{cost.cpu_s:.2f}, {cost.peak_mb:.0f}'


def _ratio(peer: float, ours: float, reach: float) -> str:
    ratio = peer / ours
    if not math.isfinite(ratio):
        return '-'
    if not math.isfinite(reach):
        return f'{ratio:.1f}'
    return f'{ratio:.1f} ({reach:.0f}{"" if ratio >= reach else ", short"})'


def limits(n_runs: int) -> None:
    print(
        f'\n## Scatter against the law, {n_runs} runs each (reach: σ_f 1.25, σ_ζ 1.45, bias 0.3,'
    )
    print('93-97 % within 2σ, recall 0.99, all found in 95 %, false modes 0.02)\n')
    print(scatter.HEADER)
    for n_channels in (6, 42):
        for duration_s in (20.0, 60.0, 120.0):
            for result in scatter.monte_carlo(n_channels, duration_s, n_runs):
                print(result.row(), flush=True)


if __name__ == '__main__':
    main()
