"""Rates of the gap workflow's verdicts, with intervals, from campaigns as they were kept."""

import math

from scipy.stats import beta

from benchmarks.gap.multibody.hidden import KINDS
from model_gap.effects import CATALOGUE

NAMES = {effect.type for effect in CATALOGUE}
SINGLE = tuple(kind for kind in KINDS if kind in NAMES)
OUTSIDE = tuple(kind for kind in KINDS if kind not in NAMES)
COLUMNS = ('what', 'seen', 'rate', '95 % interval', 'reach')
# The catalogue's nearest relative at the right place is a fair name for these.
RELATIVE = {'stribeck_friction': 'coulomb_friction', 'drifting_stiffness': 'stiffness_drift'}
# Our number of a case, and the parameter that states it.
VALUES = {
    'payload': ('mass', 'mass'),
    'joint_stiffness': ('factor', 'factor'),
    'joint_damping': ('factor', 'factor'),
    'base_compliance': ('compliance', 'compliance'),
    'foundation_mode': ('f', 'frequency'),
    'link_flexibility': ('compliance', 'compliance'),
    'rod_spring': ('k', 'stiffness'),
    'tuned_mass': ('f', 'frequency'),
    'cable': ('k', 'stiffness'),
    'coulomb_friction': ('torque', 'torque'),
    'backlash': ('half', 'half_gap'),
    'cubic_stiffness': ('a', 'alpha'),
    'speed_dependent_stiffness': ('beta', 'beta'),
    'stribeck_friction': ('torque', 'torque'),
    'load_friction': ('share', 'share'),
    'hysteresis': ('share', 'share'),
    'end_stop': ('gap', 'gap'),
    'cubic_damping': ('c', 'coefficient'),
    'tonal_disturbance': ('f', 'frequency'),
    'servo_compliance': ('f', 'frequency'),
    'command_delay': ('delay', 'delay'),
    'encoder_offset': ('offset', 'offset'),
    'sensor_gain': ('gain', 'gain'),
    'sensor_delay': ('delay', 'delay'),
    'sensor_mount_resonance': ('f', 'frequency'),
}


def counted(rows):
    """Return the table: what, how often of how many, the rate, its interval, what is asked."""
    single = [row for row in rows if row['kind'] in SINGLE]
    pairs = [row for row in rows if row['kind'] == 'pair']
    healthy = [row for row in rows if row['kind'] == 'healthy']
    outside = [row for row in rows if row['kind'] in OUTSIDE]
    rough = [row for row in rows if row['kind'] == 'rough']
    inside = [flag for row in rows for flag in _within(row)]
    return [
        rate_line('single effects, right type', map(right_type, single), '>= 95 %'),
        rate_line('single effects, right type and place', map(right_place, single), '>= 93 %'),
        rate_line('single effects, wrong and sure', map(wrong_and_sure, single), '<= 1 %'),
        rate_line('pairs, both found', map(both, pairs), '>= 85 %'),
        rate_line(
            'pairs, both, or one named and the rest admitted', map(_admitted, pairs), 'the rest'
        ),
        rate_line('healthy, mounts turned by 0.7°, named', map(_alarm, healthy), '<= 3 %'),
        rate_line('outside the catalogue, not named', map(not_named, outside), '>= 90 %'),
        rate_line('parameter within 2σ', inside, '93 to 97 %'),
        rate_line('models ±40 %, one effect: right type', map(right_type, rough), '>= 85 %'),
        rate_line('models ±40 %, one effect: wrong and sure', map(wrong_and_sure, rough), ''),
    ]


def printed(table):
    """Return the table as text."""
    widths = [max(len(row[column]) for row in [COLUMNS, *table]) for column in range(5)]
    return '\n'.join(
        '  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [COLUMNS, *table]
    )


def interval(seen, count):
    """Return the 95 % interval of a rate.

    Clopper and Pearson (1934), doi:10.1093/biomet/26.4.404.
    """
    low = 0.0 if seen == 0 else float(beta.ppf(0.025, seen, count - seen + 1))
    high = 1.0 if seen == count else float(beta.ppf(0.975, seen + 1, count - seen))
    return low, high


def rate_line(what, flags, reach):
    flags = [bool(flag) for flag in flags]
    if not flags:
        return [what, '', '', '', reach]
    seen, count = sum(flags), len(flags)
    low, high = interval(seen, count)
    return [
        what,
        f'{seen} of {count}',
        f'{seen / count:.1%}',
        f'{100 * low:.0f} to {100 * high:.0f} %',
        reach,
    ]


def right_type(row):
    """Return whether the hidden type is named, or accepted among rivals, and nothing else is."""
    return bool(row['found']) and [item['type'] for item in row['found']] == [
        row['truth'][0]['type']
    ]


def right_place(row):
    return right_type(row) and _key(row['found'][0]) == _true_key(row['truth'][0])


def wrong_and_sure(row):
    """Return whether a name was given without doubt that is not the hidden one's, or there."""
    if row['verdict'] == 'none':
        return False
    wanted = {_true_key(item) for item in row['truth']}
    return row['verdict'] == 'named' and {_key(item) for item in row['found']} != wanted


def both(row):
    return {_key(item) for item in row['found']} == {_true_key(item) for item in row['truth']}


def not_named(row):
    """Return whether something outside the catalogue got no name, or its nearest relative's."""
    relative = RELATIVE.get(row['kind'])
    fair = [_key(item) for item in row['found']] == [(relative, _place(row['truth'][0]))]
    return row['verdict'] in ('unexplained', 'ambiguous') or fair


def _admitted(row):
    wanted = {_true_key(item) for item in row['truth']}
    found = {_key(item) for item in row['found']}
    return both(row) or (row['verdict'] != 'named' and found < wanted)


def _alarm(row):
    return row['verdict'] != 'none'


def _within(row):
    """Return, of the parameter of every effect found at its place, whether it is within 2σ."""
    known = {_key(item): item['parameters'] for item in row['found']}
    for case in row['truth']:
        names, key = VALUES.get(case['type']), _true_key(case)
        if names is None or key not in known or row['verdict'] == 'unexplained':
            continue
        number = known[key][names[1]]
        if number['sigma'] is not None and math.isfinite(number['sigma']):
            yield abs(number['value'] - float(case[names[0]])) <= 2.0 * number['sigma']


def _place(case):
    sensor = case['type'].startswith('sensor') and case['place']
    return f'sensor:{case["place"]}' if sensor else case['place']


def _true_key(case):
    return case['type'], _place(case)


def _key(item):
    return item['type'], item['location'] or None
