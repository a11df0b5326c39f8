"""What gravity alone says of arms of a multibody engine in which something is hidden.

    python -m benchmarks.gap.at_rest

Before any dynamics ``ama gap`` reads the means of the accelerometers. Here the arms stand still in
five poses, so that many can be tried; they are those of ``benchmarks.gap.rates``.
"""

import argparse
import os

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')  # small matrices: threads only wait

import numpy as np

from benchmarks.gap.counts import COLUMNS, rate_line, SINGLE
from benchmarks.gap.multibody.campaign import SENSORS, still_records
from benchmarks.gap.rates import cases_of, FIRST_SEED, HEALTHY, ROBOT
from benchmarks.results import write_rows
from modal_core.channel import Sensor, SensorLayout
from modal_core.files.share import share_path
from model_gap.campaign import Campaign
from model_gap.cell import Tolerances
from model_gap.gravity import Kind, rest_of, weigh
from structural_model import load_robot

# Of each kind; what is hidden in the rest of the kinds leaves the means nearly as they are.
COUNTS = {HEALTHY: 100, 'encoder_offset': 60, 'sensor_unit': 10, 'sensor_gain': 20}
OTHERS = 5


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--first-seed', type=int, default=FIRST_SEED)
    parser.add_argument('--table', action='store_true', help='write that of the documentation')
    options = parser.parse_args()
    model = load_robot(share_path('config', 'robots', ROBOT))
    rows = [
        (kind, case, faults_of(model, kind, case, seed))
        for kind in (HEALTHY, *SINGLE)
        for seed in range(options.first_seed, options.first_seed + COUNTS.get(kind, OTHERS))
        for case in [cases_of(kind, np.random.default_rng([seed, *kind.encode()]))]
    ]
    lines = lines_of(rows)
    for line in lines:
        print('  '.join(line))
    if options.table:
        said = f'{len(rows)} arms, seeds from {options.first_seed}'
        write_rows('gap_at_rest', COLUMNS, lines, [said])


def faults_of(model, kind, cases, seed):
    """Return what gravity shows of one arm, and print it."""
    layout = SensorLayout(tuple(Sensor(name, link, at) for name, link, at in SENSORS))
    records = still_records(share_path('config', 'robots', ROBOT), cases, seed)
    campaign = Campaign(records, layout, model.joint_names)
    faults = weigh(rest_of(model, campaign), Tolerances())
    hidden = ', '.join(f'{case["type"]} {case["place"]}' for case in cases)
    told = '; '.join(fault.words() for fault in faults)
    print(f'{kind} {seed} {hidden}: {told or "nothing"}', flush=True)
    return faults


def lines_of(rows):
    """Return the table: what, how often of how many, the rate, its interval, what is asked."""
    turned = [(case[0], faults) for kind, case, faults in rows if kind == 'encoder_offset']
    units = [(case[0], faults) for kind, case, faults in rows if kind == 'sensor_unit']
    rest = [faults for kind, _, faults in rows if kind not in ('encoder_offset', 'sensor_unit')]
    within = [
        abs(fault.values[0] - case['offset']) <= 2.0 * fault.sigma
        for case, faults in turned
        for fault in faults[:1]
        if fault.kind is Kind.ENCODER and fault.place == case['place']
    ]
    return [
        rate_line(
            'encoder 1 to 3° off: named, alone or as one of two',
            [case['place'] in places(faults) for case, faults in turned],
            '',
        ),
        rate_line(
            'encoder 1 to 3° off: another one alone is named',
            [
                bool(said := places(faults)) and case['place'] not in said
                for case, faults in turned
            ],
            '<= 1 %',
        ),
        rate_line(
            'where named first: offset within 2σ',
            within,
            '93 to 97 %',
        ),
        rate_line(
            'sensor in g: named',
            [
                any(fault.kind is Kind.UNIT and fault.place == case['place'] for fault in faults)
                for case, faults in units
            ],
            '>= 95 %',
        ),
        rate_line(
            'healthy: anything is said',
            [faults for kind, _, faults in rows if kind == HEALTHY],
            '<= 3 %',
        ),
        rate_line(
            'something else hidden, or nothing: an encoder is blamed', map(places, rest), ''
        ),
    ]


def places(faults):
    """Return the joints whose encoders are named, or stand beside the one that is."""
    every = [item for fault in faults for item in (fault, fault.rival) if item is not None]
    return {item.place for item in every if item.kind is Kind.ENCODER}


if __name__ == '__main__':
    main()
