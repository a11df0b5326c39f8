"""What is hidden in an arm: each kind with numbers from its plausible range, and how it is built.

A case is a dict: ``type``, ``place``, and its numbers; ``put`` changes the description,
``laws_of`` makes the torques in gears, ``motions`` and ``faults`` what is done to the records.
"""

import math

import numpy as np

from benchmarks.gap.multibody import laws
from benchmarks.gap.multibody.description import Lump, Spring

LIFTING = ('joint_2', 'joint_3')


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def draw(kind, rng, sensors):
    """Return one case of a kind."""
    low = f'joint_{rng.integers(1, 4)}'
    site = {
        'joint': low,
        'any_joint': f'joint_{rng.integers(1, 6)}',
        'sensor': str(rng.choice(sensors)),
        'sign': float(rng.choice([-1.0, 1.0])),
    }
    place, numbers = KINDS[kind](rng, site)
    return {'type': kind, 'place': place, **numbers}


def plain(case):
    """Return a case as files keep it."""
    return {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in case.items()
    }


def _payload(rng, s):
    at = np.array([rng.uniform(0.05, 0.25), *rng.uniform(-0.12, 0.12, 2)])
    return 'flange', {'mass': rng.uniform(8, 50), 'at': at, 'sides': rng.uniform(0.1, 0.3, 3)}


def _joint_stiffness(rng, s):
    return s['any_joint'], {'factor': math.exp(s['sign'] * rng.uniform(0.15, 0.6))}


def _joint_damping(rng, s):
    return s['joint'], {'factor': math.exp(rng.uniform(0.7, 1.6))}


def _base_compliance(rng, s):
    return None, {'compliance': log_uniform(rng, 5e-9, 8e-8), 'loss': rng.uniform(2e-4, 8e-4)}


def _foundation_mode(rng, s):
    way = str(rng.choice(['tx', 'ty', 'rx', 'ry']))
    numbers = {'way': way, 'mass': rng.uniform(1500, 4000), 'gyration': rng.uniform(0.8, 1.3)}
    return None, {**numbers, 'f': rng.uniform(8, 30), 'zeta': rng.uniform(0.02, 0.06)}


def _link_flexibility(rng, s):
    share = rng.uniform(0.35, 0.65)
    if rng.integers(2):
        link, at, axis = 'link_2', (0.0, 0.0, 0.7 * share), (0.0, 1.0, 0.0)
    else:
        axis = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))[rng.integers(2)]
        link, at = 'link_4', (0.8 * share, 0.0, 0.0)
    numbers = {'at': at, 'axis': axis, 'near': rng.uniform(0.4, 0.6)}
    return link, {**numbers, 'compliance': rng.uniform(5e-8, 4e-7)}


def _tuned_mass(rng, s):
    link, at = (('link_3', (0.2, 0.0, 0.1)), ('link_4', (0.4, 0.0, 0.0)))[rng.integers(2)]
    axis = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))[rng.integers(2)]
    numbers = {'mass': rng.uniform(6, 25), 'f': rng.uniform(8, 30)}
    return link, {**numbers, 'at': at, 'axis': axis, 'zeta': rng.uniform(0.02, 0.1)}


def _cable(rng, s):
    link = ('link_3', 'link_4')[rng.integers(2)]
    way = rng.uniform(-1.0, 1.0, 2)
    anchor = (*(1.5 * way), rng.uniform(1.5, 2.8))
    at = (0.1, 0.1, 0.2) if link == 'link_3' else (0.4, 0.1, 0.1)
    numbers = {'k': log_uniform(rng, 3e4, 2e5), 'pull': rng.uniform(100, 1000)}
    return link, {**numbers, 'anchor': anchor, 'at': at}


def _gravity_compensator(rng, s):
    return 'joint_2', {'k': rng.uniform(5e4, 2e5), 'crank': 0.25, 'arm': 0.9}


def _coulomb_friction(rng, s):
    return s['joint'], {'torque': rng.uniform(60, 250), 'stiffer': rng.uniform(25, 60)}


def _stribeck_friction(rng, s):
    place, numbers = _coulomb_friction(rng, s)
    numbers['torque'] = rng.uniform(60, 150)
    return place, {**numbers, 'static': numbers['torque'] * rng.uniform(1.5, 2.5)}


def _load_friction(rng, s):
    place, numbers = _coulomb_friction(rng, s)
    numbers['torque'] = rng.uniform(20, 60)
    return place, {**numbers, 'share': rng.uniform(0.05, 0.15)}


def _backlash(rng, s):
    return s['joint'], {'half': rng.uniform(3e-5, 2e-4)}


def _cubic_stiffness(rng, s):
    return s['joint'], {'a': log_uniform(rng, 3e5, 4e6)}


def _speed_dependent_stiffness(rng, s):
    return s['joint'], {'beta': s['sign'] * rng.uniform(1, 4)}


def _hysteresis(rng, s):
    return s['joint'], {'share': rng.uniform(0.2, 0.5), 'limit': rng.uniform(2e-5, 8e-5)}


def _end_stop(rng, s):
    numbers = {'gap': rng.uniform(5e-5, 1.5e-4), 'stiffer': rng.uniform(2, 4)}
    return s['joint'], {**numbers, 'loss': rng.uniform(0.5, 2.0)}


def _cubic_damping(rng, s):
    return s['joint'], {'c': log_uniform(rng, 3e7, 5e8)}


def _transmission_error(rng, s):
    return s['joint'], {'amplitude': rng.uniform(1e-4, 4e-4), 'order': 1.0}


def _tonal_disturbance(rng, s):
    numbers = {'f': rng.uniform(8, 50), 'size': rng.uniform(50, 250)}
    return s['joint'], numbers


def _servo_compliance(rng, s):
    return None, {'f': rng.uniform(15, 60), 'zeta': rng.uniform(0.3, 0.9)}


def _command_delay(rng, s):
    return None, {'delay': rng.uniform(0.003, 0.015)}


def _encoder_offset(rng, s):
    joint = ('joint_2', 'joint_3', 'joint_5')[rng.integers(3)]
    return joint, {'offset': s['sign'] * math.radians(rng.uniform(1.0, 3.0))}


def _sensor_gain(rng, s):
    return s['sensor'], {'gain': math.exp(s['sign'] * rng.uniform(0.08, 0.6))}


def _sensor_unit(rng, s):
    return s['sensor'], {}


def _sensor_polarity(rng, s):
    return s['sensor'], {'axis': int(rng.integers(3))}


def _sensor_axis_swap(rng, s):
    return s['sensor'], {'axes': ((0, 1), (0, 2), (1, 2))[rng.integers(3)]}


def _sensor_rotation(rng, s):
    axis = rng.standard_normal(3)
    return s['sensor'], {'vector': axis / np.linalg.norm(axis) * rng.uniform(0.08, 0.6)}


def _sensor_position(rng, s):
    axis = rng.standard_normal(3)
    return s['sensor'], {'shift': axis / np.linalg.norm(axis) * rng.uniform(0.05, 0.15)}


def _sensor_delay(rng, s):
    return s['sensor'], {'delay': s['sign'] * rng.uniform(0.001, 0.01)}


def _sensor_mount_resonance(rng, s):
    return s['sensor'], {'f': rng.uniform(65, 160), 'zeta': 0.05}


def _clipping(rng, s):
    return None, {'at': rng.uniform(1.0, 2.0)}


def _clock_drift(rng, s):
    return None, {'rate': s['sign'] * rng.uniform(1e-4, 3e-4)}


def _loose_sensor(rng, s):
    return s['sensor'], {'f': rng.uniform(40, 90), 'at': 1.5, 'size': 1.0}


def _drifting_stiffness(rng, s):
    return s['joint'], {'share': rng.uniform(0.1, 0.3)}


def _lopsided_spring(rng, s):
    return s['joint'], {'s': s['sign'] * rng.uniform(0.2, 0.4)}


def _knocks(rng, s):
    return s['joint'], {'size': rng.uniform(400, 1200), 'per_s': rng.uniform(0.5, 2.0)}


def _rod_spring(rng, s):
    return 'joint_2+joint_3', {'k': rng.uniform(2e5, 2e6)}


KINDS = {
    'payload': _payload,
    'joint_stiffness': _joint_stiffness,
    'joint_damping': _joint_damping,
    'base_compliance': _base_compliance,
    'foundation_mode': _foundation_mode,
    'link_flexibility': _link_flexibility,
    'rod_spring': _rod_spring,
    'tuned_mass': _tuned_mass,
    'cable': _cable,
    'gravity_compensator': _gravity_compensator,
    'coulomb_friction': _coulomb_friction,
    'backlash': _backlash,
    'cubic_stiffness': _cubic_stiffness,
    'speed_dependent_stiffness': _speed_dependent_stiffness,
    'hysteresis': _hysteresis,
    'end_stop': _end_stop,
    'cubic_damping': _cubic_damping,
    'transmission_error': _transmission_error,
    'tonal_disturbance': _tonal_disturbance,
    'servo_compliance': _servo_compliance,
    'command_delay': _command_delay,
    'encoder_offset': _encoder_offset,
    'sensor_gain': _sensor_gain,
    'sensor_unit': _sensor_unit,
    'sensor_polarity': _sensor_polarity,
    'sensor_axis_swap': _sensor_axis_swap,
    'sensor_rotation': _sensor_rotation,
    'sensor_position': _sensor_position,
    'sensor_delay': _sensor_delay,
    'sensor_mount_resonance': _sensor_mount_resonance,
    'clipping': _clipping,
    'clock_drift': _clock_drift,
    'loose_sensor': _loose_sensor,
    'drifting_stiffness': _drifting_stiffness,
    'lopsided_spring': _lopsided_spring,
    'knocks': _knocks,
    'stribeck_friction': _stribeck_friction,
    'load_friction': _load_friction,
}
"""How each kind is drawn."""


def put(case, arm):
    """Change the description of an arm: what the engine itself computes."""
    build = STRUCTURAL.get(case['type'])
    if build is not None:
        build(case, arm)


def _put_payload(case, arm):
    box = np.array(case['sides'])
    inertia = case['mass'] / 12.0 * np.diag(box @ box - box**2)
    arm.link('flange').lumps.append(Lump(case['mass'], case['at'], inertia))


def _put_joint_stiffness(case, arm):
    spring = arm.axis(case['place']).drive
    spring.k, spring.c = spring.k * case['factor'], spring.c * case['factor']


def _put_joint_damping(case, arm):
    arm.axis(case['place']).drive.c *= case['factor']


def _put_base_compliance(case, arm):
    """A plate on a pad that rocks under the base: in series with its springs by itself."""
    spring = Spring(1.0 / case['compliance'], case['loss'] / case['compliance'])
    ways = {'rx': spring, 'ry': spring}
    arm.below.append({'mass': 100.0, 'gyration': 0.7, 'ways': ways})


def _put_foundation_mode(case, arm):
    own = case['mass'] * (1.0 if case['way'][0] == 't' else case['gyration'] ** 2)
    omega = 2.0 * math.pi * case['f']
    spring = Spring(own * omega**2, 2.0 * case['zeta'] * own * omega)
    ways = {case['way']: spring}
    arm.below.append({'mass': case['mass'], 'gyration': case['gyration'], 'ways': ways})


def _put_link_flexibility(case, arm):
    k = 1.0 / case['compliance']
    spring = Spring(k, 4e-4 * k)
    kept = {key: case[key] for key in ('at', 'axis', 'near')}
    arm.hinge = {'link': case['place'], 'spring': spring, **kept}


def _put_tuned_mass(case, arm):
    kept = {key: case[key] for key in ('at', 'axis', 'mass', 'f', 'zeta')}
    arm.swinging.append({'link': case['place'], **kept})


def _put_cable(case, arm):
    """A hose tied anew in every pose: as stiff, kept, it would pull with tens of kilonewtons."""
    ends = {'from': (None, case['anchor']), 'to': (case['place'], case['at'])}
    arm.tendons.append({'k': case['k'], 'pull': case['pull'], **ends})


def _put_gravity_compensator(case, arm):
    """A spring from the turning frame to a crank on the lower arm, long and pulled."""
    joint = arm.axis('joint_2')
    below = arm.links[[link.name for link in arm.links].index('link_2') - 1].name
    anchor = joint.shift + np.array([0.0, 0.1, -case['arm']])
    crank = (0.0, 0.1, case['crank'])
    ends = {'from': (below, anchor), 'to': ('link_2', crank)}
    arm.tendons.append({'k': case['k'], 'length': 0.8 * case['arm'], **ends})


STRUCTURAL = {
    'payload': _put_payload,
    'joint_stiffness': _put_joint_stiffness,
    'joint_damping': _put_joint_damping,
    'base_compliance': _put_base_compliance,
    'foundation_mode': _put_foundation_mode,
    'link_flexibility': _put_link_flexibility,
    'tuned_mass': _put_tuned_mass,
    'cable': _put_cable,
    'gravity_compensator': _put_gravity_compensator,
}


def law_of(case, arm, pose, duration_s, rng):
    """Return the torque in a gear that a case is; None: it is none."""
    make = LAWS.get(case['type'])
    if make is None:
        return None
    if case['type'] == 'servo_compliance':
        return laws.Servo(arm.k, arm.c, arm.rotors, 2.0 * math.pi * case['f'], case['zeta'])
    gear = int(case['place'][-1]) - 1
    return make(case, gear, float(arm.k[gear]), arm, pose, duration_s, rng)


def _knocking(case, gear, k, arm, pose, duration_s, rng):
    times = np.sort(rng.uniform(0.0, duration_s, rng.poisson(case['per_s'] * duration_s)))
    return Knocks(gear, k, size=case['size'], times=times)


class Knocks(laws.Law):
    """Short pushes in one joint, at times that no one knows."""

    def __init__(self, gear, k, size, times):
        super().__init__(gear, k)
        self.size, self.times = size, times

    def torque(self, time, twist, rate, position, velocity, inner):
        found = np.zeros(laws.GEARS)
        number = int(np.searchsorted(self.times, time)) - 1
        since = time - self.times[number] if number >= 0 else 1.0
        if since < 0.01:
            found[self.gear] = self.size * math.sin(math.pi * since / 0.01) ** 2
        return found, ()


def _rod(case, gear, k, arm, *_):
    weights = np.array([0.0, 1.0, -1.0, 0.0, 0.0, 0.0])
    row = np.linalg.solve(arm.couple.T, weights)
    return laws.Rod(gear, k, stiffness=case['k'], loss_s=3e-4, row=row)


LAWS = {
    'rod_spring': _rod,
    'coulomb_friction': lambda e, g, k, *_: laws.Friction(
        g, k, level=e['torque'], bristle=e['stiffer'] * k
    ),
    'stribeck_friction': lambda e, g, k, *_: laws.Friction(
        g, k, level=e['torque'], bristle=e['stiffer'] * k, static=e['static']
    ),
    'load_friction': lambda e, g, k, *_: laws.Friction(
        g, k, level=e['torque'], bristle=e['stiffer'] * k, share=e['share']
    ),
    'backlash': lambda e, g, k, arm, *_: laws.Play(g, k, half=e['half'], c=float(arm.c[g])),
    'cubic_stiffness': lambda e, g, k, *_: laws.Hardening(g, k, a=e['a']),
    'speed_dependent_stiffness': lambda e, g, k, *_: laws.SpeedStiffening(g, k, beta=e['beta']),
    'hysteresis': lambda e, g, k, *_: laws.BoucWen(g, k, share=e['share'], limit=e['limit']),
    'end_stop': lambda e, g, k, *_: laws.Stop(
        g, k, gap=e['gap'], buffer=e['stiffer'] * k, loss=e['loss']
    ),
    'cubic_damping': lambda e, g, k, *_: laws.FastDamping(g, k, c=e['c']),
    'transmission_error': lambda e, g, k, arm, pose, *_: laws.Ripple(
        g,
        k,
        amplitude=e['amplitude'],
        order=e['order'] * float(arm.ratios[g]),
        at=float(arm.couple[g] @ pose),
        row=arm.couple[g],
    ),
    'tonal_disturbance': lambda e, g, k, arm, pose, duration, rng: laws.Hum(
        g, k, size=e['size'], f=e['f'], phase=rng.uniform(0.0, 2.0 * math.pi)
    ),
    'servo_compliance': True,
    'drifting_stiffness': lambda e, g, k, arm, pose, duration, rng: laws.Softening(
        g, k, rate=e['share'] / duration
    ),
    'lopsided_spring': lambda e, g, k, *_: laws.Lopsided(g, k, s=e['s']),
    'knocks': _knocking,
}
"""By kind: of (case, gear, its stiffness, arm, pose, duration, generator)."""
