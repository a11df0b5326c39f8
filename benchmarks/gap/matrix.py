"""Hide effects in an arm that shares no code with the suite, and see what the workflow says.

    python -m benchmarks.gap.matrix --seeds 2 --out gap_matrix.json

Prints one line per campaign as it ends, then: how often type and place were right, false alarms,
verdicts on effects outside the catalogue, pairs of effects, parameters within two deviations.
With ``--out`` every campaign is written when it ends, and those already there are not run again.

    python -m benchmarks.gap.matrix --calibrate 60 --first-seed 1000 --quick --out healthy.json

measures on healthy arms what the thresholds of a verdict are set by, and how often each is passed.
"""

import argparse
import json
from pathlib import Path
import time

import numpy as np
from scipy.stats import beta

from benchmarks.gap.hidden_effects import draw
from benchmarks.gap.table import COLUMNS, table_rows
from benchmarks.results import write_rows
from modal_core.channel import Sensor, SensorLayout
from modal_core.files.atomic_file import write_text
from modal_core.files.share import share_path
from modal_core.work.side_by_side import processor_time_s
from model_gap.campaign import at_times, Campaign, GapRecord
from model_gap.decide.adequacy import adequacy
from model_gap.find_gap import find_gap
from model_gap.gap_json import found_effects
from structural_model import load_robot
from test.support.hidden_campaign import make_campaign, picked_up, SENSORS

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
SENSOR_NAMES = [name for name, _, _ in SENSORS]
TABLES = ('gap_full_size', 'gap_outside', 'gap_small')
QUICK = {'n_fit': 3, 'n_held': 2, 'duration': 16.0}
OUTSIDE = (
    'drifting_stiffness', 'clipping', 'stribeck_friction', 'loose_sensor', 'picked_up_payload',
)  # fmt: skip
# The catalogue's nearest relative at the right place is a fair name for these.
RELATIVE = {'stribeck_friction': 'coulomb_friction'}


SINGLE = (
    'payload', 'joint_stiffness', 'joint_damping', 'base_compliance', 'link_flexibility',
    'rod_spring', 'tuned_mass', 'coulomb_friction', 'backlash', 'cubic_stiffness',
    'speed_dependent_stiffness', 'hysteresis', 'end_stop', 'transmission_error',
    'tonal_disturbance',
    'servo_compliance', 'command_delay', 'clock_drift', 'sensor_gain',
    'sensor_polarity', 'sensor_axis_swap', 'sensor_rotation', 'sensor_delay',
    'sensor_mount_resonance', 'sensor_mass',
)  # fmt: skip
VALUE = {
    'payload': ('mass', 'mass'), 'joint_stiffness': ('factor', 'factor'),
    'joint_damping': ('factor', 'factor'), 'base_compliance': ('compliance', 'compliance'),
    'link_flexibility': ('compliance', 'compliance'), 'rod_spring': ('k', 'stiffness'),
    'tuned_mass': ('f', 'frequency'), 'coulomb_friction': ('torque', 'torque'),
    'hysteresis': ('share', 'share'), 'end_stop': ('gap', 'gap'),
    'backlash': ('gap', 'half_gap'), 'cubic_stiffness': ('alpha', 'alpha'),
    'servo_compliance': ('f', 'frequency'), 'tonal_disturbance': ('f', 'frequency'),
    'speed_dependent_stiffness': ('beta', 'beta'),
    'command_delay': ('delay', 'delay'), 'clock_drift': ('rate', 'rate'),
    'sensor_gain': ('gain', 'gain'),
    'sensor_delay': ('delay', 'delay'), 'sensor_mass': ('mass', 'mass'),
}  # fmt: skip


def place_of(effect):
    if 'sensor' in effect:
        return f'sensor:{effect["sensor"]}'
    if 'weights' in effect:
        return 'joint_2+joint_3'
    return effect.get('joint') or effect.get('link')


def read_back(records):
    """Make workflow records of hidden ones, through the same resampling as recordings."""
    found = []
    for item in records:
        times = np.arange(len(item.acceleration)) / item.rate_hz
        times = times[times <= (len(item.position) - 1) / item.joint_rate_hz]
        pose = item.position.mean(axis=0)
        motion = [
            at_times(item.velocity, item.joint_rate_hz, times, order, 110.0) for order in (1, 0)
        ]
        shift = at_times(item.position - pose, item.joint_rate_hz, times, 0, 110.0)
        found.append(
            GapRecord(
                item.name,
                pose,
                str(item.level),
                item.rate_hz,
                item.acceleration[: len(times)],
                motion[0],
                motion[1],
                shift,
                heldout=item.heldout,
            )
        )
    return tuple(found)


def run(effects, seed, size):
    model = load_robot(ROBOT)
    if effects and effects[0]['type'] == 'picked_up_payload':
        records = picked_up(ROBOT, {**effects[0], 'type': 'payload'}, seed, **size)
    else:
        records = make_campaign(ROBOT, effects, seed, **size)
    layout = SensorLayout(tuple(Sensor(name, link, at) for name, link, at in SENSORS))
    started = processor_time_s()
    result = find_gap(model, Campaign(read_back(records), layout, model.joint_names))
    return result, processor_time_s() - started


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seeds', type=int, default=1)
    parser.add_argument('--first-seed', type=int, default=100)
    parser.add_argument(
        '--only', default='', help='comma-separated kinds; single, outside, pair, none'
    )
    parser.add_argument('--quick', action='store_true', help='3 + 2 poses of 16 s')
    parser.add_argument('--calibrate', type=int, metavar='N', help='N healthy arms, no effects')
    parser.add_argument('--tolerance', type=float, default=1.0, help='times the stated tolerances')
    parser.add_argument('--minutes', type=float, default=np.inf, help='then begin nothing new')
    parser.add_argument('--out', type=Path)
    parser.add_argument('--table', choices=TABLES, help='of the documentation, to be written anew')
    options = parser.parse_args()
    if options.calibrate:
        calibrate(options)
        return
    kinds = []
    for kind in (options.only or 'none,single,outside,pair').split(','):
        kinds += {'single': SINGLE, 'outside': OUTSIDE}.get(kind, [kind])
    rows = []
    if options.out and options.out.exists():
        rows = json.loads(options.out.read_text())
    done = {(row['kind'], row['seed'], row['quick']) for row in rows}
    end = time.monotonic() + 60.0 * options.minutes
    for seed in range(options.first_seed, options.first_seed + options.seeds):
        for kind in kinds:
            if (kind, seed, options.quick) in done or time.monotonic() > end:
                continue
            rows.append(one(kind, seed, options.quick))
            if options.out:
                write_text(options.out, json.dumps(rows, indent=1))
    summary(rows)
    if options.table:
        write_rows(options.table, COLUMNS, table_rows(rows))


def calibrate(options):
    """Print what healthy arms show of every number a verdict depends on."""
    rows = []
    if options.out and options.out.exists():
        rows = json.loads(options.out.read_text())
    size = {**(QUICK if options.quick else {}), 'size': options.tolerance}
    for seed in range(options.first_seed, options.first_seed + options.calibrate):
        case = {'seed': seed, 'quick': options.quick, 'tolerance': options.tolerance}
        if any(case.items() <= row.items() for row in rows):
            continue
        result, seconds = run([], seed, size)
        step = result.search.rounds[0]
        rows.append(
            {
                **case,
                'verdict': result.decision.verdict.value,
                'promise': step.trials[0].gain if step.trials else 0.0,
                'promised': repr(step.trials[0].effect) if step.trials else '',
                'gain': step.candidates[0].gain if step.candidates else 0.0,
                **left_over(result.search, step.before),
                'cpu_s': seconds,
            }
        )
        print(rows[-1], flush=True)
        if options.out:
            write_text(options.out, json.dumps(rows, indent=1))
    rows = [row for row in rows if row['quick'] == options.quick]
    rows = [row for row in rows if row['tolerance'] == options.tolerance]
    alarms = sum(row['verdict'] != 'none' for row in rows)
    print(f'{len(rows)} healthy arms, tolerances times {options.tolerance:g}: {alarms} alarms,')
    print(f'a rate below {rate_bound(alarms, len(rows)):.1%} with 95 % confidence')
    for name in ('promise', 'gain', 'fitted', 'heldout', 'worst', 'worst_heldout', 'stretched'):
        values = np.array([row[name] for row in rows])
        figures = np.quantile(values, [0.5, 0.9, 0.95]).tolist()
        print(f'{name:14s} median {figures[0]:.2f}, 90 % {figures[1]:.2f}, 95 % {figures[2]:.2f}')
        print(f'{"":14s} largest {values.max():.2f}, one in 1000 {one_in_1000(values):.2f}')


def left_over(search, fit):
    found = adequacy(search, fit)
    return {
        'fitted': found.fitted,
        'heldout': found.heldout,
        'worst': found.worst.misfit,
        'worst_place': found.worst.place,
        'worst_heldout': found.worst_heldout.misfit,
        'worst_heldout_place': found.worst_heldout.place,
        'stretched': found.stretched,
        'stretched_name': found.stretched_name,
    }


def rate_bound(seen, count, confidence=0.95):
    """Return the upper bound of a rate (Clopper and Pearson 1934, doi:10.1093/biomet/26.4.404)."""
    return 1.0 if seen == count else float(beta.ppf(confidence, seen + 1, count - seen))


def one_in_1000(values):
    """Return what one healthy arm in 1000 would pass, if their tail is Gumbel's (by moments)."""
    scale = float(np.std(values)) * np.sqrt(6.0) / np.pi
    return float(np.mean(values) - scale * (np.euler_gamma + np.log(-np.log(0.999))))


def one(kind, seed, quick):
    size = QUICK if quick else {}
    rng = np.random.default_rng([seed, *kind.encode()])
    if kind == 'none':
        effects = []
    elif kind == 'pair':
        chosen = rng.choice(
            [
                'payload',
                'joint_stiffness',
                'base_compliance',
                'sensor_gain',
                'sensor_delay',
                'command_delay',
            ],
            2,
            replace=False,
        )
        effects = [{'type': str(item), **draw(str(item), rng, SENSOR_NAMES)} for item in chosen]
    else:
        effects = [{'type': kind, **draw(kind, rng, SENSOR_NAMES)}]
    result, seconds = run(effects, seed, size)
    found = found_effects(result)
    candidates = result.search.rounds[0].candidates
    trials = result.search.rounds[0].trials
    first = candidates[0].effect if candidates else None
    best = candidates[0].fit if candidates else result.search.rounds[0].before
    if result.decision.accepted:
        best = result.decision.accepted[-1].fit
    row = {
        'kind': kind,
        'seed': seed,
        'quick': quick,
        'verdict': result.decision.verdict.value,
        'truth': [(item['type'], place_of(item)) for item in effects],
        'found': [(item['type'], item['location']) for item in found],
        'first': first.key if first else None,
        'gain': candidates[0].gain if candidates else 0.0,
        'gap_before': result.gap_before_heldout,
        'gap_after': result.gap_after_heldout,
        'noise': result.noise_floor,
        'misfit': result.search.rounds[0].before.misfit,
        'misfit_heldout': result.search.rounds[0].heldout_before,
        'left': candidates[0].fit.misfit if candidates else None,
        'left_heldout': candidates[0].heldout_misfit if candidates else None,
        'promise': trials[0].gain if trials else 0.0,
        'best': left_over(result.search, best),
        'rounds': [
            [step.trials[0].gain if step.trials else 0.0]
            + [(*item.effect.key, item.gain) for item in step.candidates[:2]]
            for step in result.search.rounds
        ],
        'reasons': result.decision.reasons,
        'cpu_s': seconds,
        'estimate': estimate(effects, found),
    }
    print(
        f'{kind:26s} seed {seed} {row["verdict"]:12s} truth {row["truth"]} found {row["found"]} '
        f'first {row["first"]} gain {row["gain"]:.0f} held-out {row["gap_before"]:.3f} -> '
        f'{row["gap_after"]:.3f} (noise {row["noise"]:.3f}) estimate {row["estimate"]} '
        f'{seconds:.0f} CPU-s',
        flush=True,
    )
    return row


def estimate(effects, found):
    """Return true value, fitted value and its standard deviation, when the type is right."""
    if len(effects) != 1 or len(found) != 1 or effects[0]['type'] != found[0]['type']:
        return None
    names = VALUE.get(effects[0]['type'])
    if names is None:
        return None
    item = found[0]['parameters'][names[1]]
    return float(effects[0][names[0]]), item['value'], item['sigma']


def named_stranger(row):
    """Return whether something outside the catalogue got a name, or went unnoticed."""
    relative = [[RELATIVE.get(row['kind']), row['truth'][0][1]]]
    found = [list(item) for item in row['found']]
    fair = row['verdict'] == 'named' and found == relative
    return row['verdict'] not in ('unexplained', 'ambiguous') and not fair


def share(flags):
    flags = [bool(flag) for flag in flags]
    return f'{sum(flags)} of {len(flags)}'


def summary(rows):
    if not rows:
        print('no campaigns')
        return
    single = [row for row in rows if row['kind'] in SINGLE]
    types = [row['first'] is not None and row['first'][0] == row['kind'] for row in single]
    places = [
        ok and (row['first'][1] or None) == row['truth'][0][1]
        for ok, row in zip(types, single, strict=True)
    ]
    print('right type first:', share(types), '| and right place:', share(places))
    print('named:', share(row['verdict'] == 'named' for row in single))
    print(
        'named, and wrong type:',
        share(row['verdict'] == 'named' and row['found'][0][0] != row['kind'] for row in single),
    )
    print(
        'false alarms with no effect:',
        share(row['verdict'] != 'none' for row in rows if row['kind'] == 'none'),
    )
    print(
        'outside the catalogue, not named:',
        share(not named_stranger(row) for row in rows if row['kind'] in OUTSIDE),
    )
    pairs = [row for row in rows if row['kind'] == 'pair']
    print(
        'pairs, both found:',
        share(
            {tuple(item) for item in row['truth']} == {tuple(item) for item in row['found']}
            for row in pairs
        ),
    )
    known = [row['estimate'] for row in rows if row['estimate']]
    inside = [abs(value - truth) <= 2.0 * sigma for truth, value, sigma in known]
    print('parameter within two deviations:', share(inside))
    named = [row for row in rows if row['verdict'] == 'named']
    print(
        'held-out gap after over noise, named, largest:',
        max([row['gap_after'] / row['noise'] for row in named], default=float('nan')),
    )
    print(
        'CPU seconds, median and largest:',
        np.median([row['cpu_s'] for row in rows]),
        max(row['cpu_s'] for row in rows),
    )
    print('confusion (truth: verdict, first candidate)')
    for kind in dict.fromkeys(row['kind'] for row in rows):
        entries = [
            f'{row["verdict"]}/{row["first"][0] if row["first"] else "-"}'
            for row in rows
            if row['kind'] == kind
        ]
        print(f'  {kind:26s}', ', '.join(entries))


if __name__ == '__main__':
    main()
