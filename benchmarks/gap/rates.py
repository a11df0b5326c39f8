"""Hide effects in arms of a multibody engine, and count what the workflow says of them.

    python -m benchmarks.gap.rates --seeds 1 --out gap_rates.json

Campaigns are small: 3 fitting and 2 held-out poses, two levels, 16 s each. Every campaign is
written as it ends, and those already there are not run again: stopped, it goes on. With
``--minutes`` nothing new begins after that time; a round's order is drawn, so that what was run
until then is a fair sample of it.
"""

import argparse
from dataclasses import replace
import json
import os
from pathlib import Path
import time

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')  # small matrices: threads only wait

import numpy as np

from benchmarks.gap.counts import COLUMNS, counted, OUTSIDE, printed, SINGLE
from benchmarks.gap.multibody.campaign import Conditions, make_records, SENSORS
from benchmarks.gap.multibody.hidden import draw, plain
from benchmarks.results import write_rows
from modal_core.channel import Sensor, SensorLayout
from modal_core.files.atomic_file import write_text
from modal_core.files.share import share_path
from modal_core.work.side_by_side import processor_time_s
from model_gap.campaign import Campaign
from model_gap.cell import Tolerances
from model_gap.decide.adequacy import adequacy
from model_gap.find_gap import find_gap
from model_gap.gap_json import found_effects
from model_gap.search import SearchSettings
from structural_model import load_robot

ROBOT = 'irb6660_205_190'
FIRST_SEED = 770000  # of reports; development uses 700000 to 709999
ROUGH = 0.4
# Beside a model known roughly, and in pairs: effects of an arm, of the command and of sensors.
BESIDE = (
    'payload', 'base_compliance', 'tuned_mass', 'coulomb_friction', 'backlash', 'hysteresis',
    'command_delay', 'sensor_gain', 'sensor_delay', 'tonal_disturbance',
)  # fmt: skip
PAIRED = (*BESIDE, 'joint_stiffness', 'joint_damping', 'sensor_position')
HEALTHY, PAIR, ROUGHLY = 'healthy', 'pair', 'rough'


def kinds():
    """Return a round: each kind once, the other rows of the table six times."""
    return [*SINGLE, *[HEALTHY] * 6, *OUTSIDE, *[PAIR] * 6, *[ROUGHLY] * 6]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seeds', type=int, default=1, help='rounds')
    parser.add_argument('--first-seed', type=int, default=FIRST_SEED)
    parser.add_argument('--only', default='', help='comma-separated kinds')
    parser.add_argument('--minutes', type=float, default=float('inf'))
    parser.add_argument('--out', type=Path, default=Path('gap_rates.json'))
    parser.add_argument('--table', action='store_true', help='write that of the documentation')
    options = parser.parse_args()
    rows = json.loads(options.out.read_text()) if options.out.exists() else []
    done = {(row['kind'], row['seed']) for row in rows}
    end = time.monotonic() + 60.0 * options.minutes
    for kind, seed in order(options):
        if (kind, seed) in done:
            continue
        if time.monotonic() > end:
            break
        try:
            rows.append(one(kind, seed))
        except FloatingPointError as reason:  # no verdict on an arm that could not be simulated
            print(f'{kind:22s} {seed} left out: {reason}', flush=True)
            continue
        write_text(options.out, json.dumps(rows, indent=1))
    table = counted(rows)
    print(printed(table))
    if options.table:
        said = f'{len(rows)} campaigns, seeds from {options.first_seed}'
        write_rows('gap_rates', COLUMNS, table, [said])


def order(options):
    """Return (kind, seed) of every campaign; a kind that stands twice in a round has two seeds."""
    chosen = options.only.split(',') if options.only else kinds()
    found = []
    for number in range(options.seeds):
        seen, drawn = {}, []
        first = options.first_seed + 10 * number
        for kind in chosen:
            seen[kind] = seen.get(kind, -1) + 1
            drawn.append((kind, first + seen[kind]))
        found += [drawn[place] for place in np.random.default_rng(first).permutation(len(drawn))]
    return found


def cases_of(kind, rng):
    """Return what is hidden in a campaign of a kind."""
    if kind == HEALTHY:
        return []
    if kind == PAIR:
        chosen = rng.choice(PAIRED, 2, replace=False)
        return [draw(str(item), rng, [name for name, _, _ in SENSORS]) for item in chosen]
    if kind == ROUGHLY:
        kind = str(rng.choice(BESIDE))
    return [draw(kind, rng, [name for name, _, _ in SENSORS])]


def one(kind, seed):
    """Return what the workflow says of one campaign, and print it."""
    cases = cases_of(kind, np.random.default_rng([seed, *kind.encode()]))
    conditions, settings = Conditions(), SearchSettings()
    if kind == ROUGHLY:
        conditions = replace(conditions, stiffness=ROUGH)
        settings = SearchSettings(tolerances=Tolerances(stiffness=ROUGH))
    folder = share_path('config', 'robots', ROBOT)
    begun = processor_time_s()
    records = make_records(folder, cases, seed, conditions)
    simulated = processor_time_s() - begun
    model = load_robot(folder)
    layout = SensorLayout(tuple(Sensor(name, link, at) for name, link, at in SENSORS))
    begun = processor_time_s()
    result = find_gap(model, Campaign(records, layout, model.joint_names), settings)
    row = {
        'kind': kind,
        'seed': seed,
        'truth': [plain(case) for case in cases],
        'verdict': result.decision.verdict.value,
        'found': found_effects(result),
        'rivals': [list(item.effect.key) for item in result.decision.rivals],
        **_course(result),
        'simulation_cpu_s': simulated,
        'cpu_s': processor_time_s() - begun,
    }
    _tell(row)
    return row


def _course(result):
    """Return what a person needs to see why a verdict is wrong."""
    rounds = [
        {
            'promised': [(*item.effect.key, item.gain) for item in step.trials[:3]],
            'refined': [(*item.effect.key, item.gain) for item in step.candidates[:3]],
        }
        for step in result.search.rounds
    ]
    before = adequacy(result.search, result.search.rounds[0].before)
    return {
        'gap_before': result.gap_before_heldout,
        'gap_after': result.gap_after_heldout,
        'noise': result.noise_floor,
        'misfit': before.fitted,
        'misfit_heldout': before.heldout,
        'stretched': [before.stretched_name, before.stretched],
        'rounds': rounds,
        'reasons': result.decision.reasons,
        'at_rest': [fault.words() for fault in result.faults_at_rest],
    }


def _tell(row):
    hidden = ' + '.join(f'{item["type"]} {item["place"] or ""}' for item in row['truth'])
    found = ' + '.join(f'{item["type"]} {item["location"] or ""}' for item in row['found'])
    print(
        f'{row["kind"]:22s} {row["seed"]} {hidden or "nothing"}: {row["verdict"]} {found}; '
        f'held-out {row["gap_before"]:.3f} -> {row["gap_after"]:.3f} (noise {row["noise"]:.3f}) '
        f'{row["cpu_s"]:.0f} CPU-s',
        flush=True,
    )


if __name__ == '__main__':
    main()
