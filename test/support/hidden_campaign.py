"""Campaigns with an effect hidden in them, made by the independent arm."""

from dataclasses import dataclass, replace
import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import fftconvolve

from test.support.independent_arm import linearise, read_arm, respond, turn

SENSORS = (
    ('frame', 'link_1', (0.20, 0.42, 0.05)),
    ('lower_arm', 'link_2', (-0.10, -0.15, 0.68)),
    ('elbow', 'link_3', (0.30, -0.15, 0.28)),
    ('spindle', 'flange', (0.20, 0.0, 0.08)),
)
LEVELS = (0.35, 1.0)


@dataclass
class HiddenRecord:
    name: str
    pose: np.ndarray
    level: int
    heldout: bool
    rate_hz: float
    acceleration: np.ndarray
    joint_rate_hz: float
    position: np.ndarray
    velocity: np.ndarray


def counted(records, step_rad):
    """The same, their motion known by the steps of encoders alone."""
    return [
        replace(
            item,
            position=np.round(item.position / step_rad) * step_rad,
            velocity=np.full_like(item.velocity, np.nan),
        )
        for item in records
    ]


def poses(rng, count, centre=(0, 0.2, 0.1, 0.3, -0.6, 0.2), spread=(1.0, 0.5, 0.5, 1.2, 0.7, 1.5)):
    return [np.array(centre) + np.array(spread) * rng.uniform(-1, 1, 6) for _ in range(count)]


def excitation(rng, samples, rate, rms, joints=6, band=(2.0, 55.0), bias=None):
    """Random accelerations of the motors and their positions, at rest at both ends."""
    f = np.fft.rfftfreq(samples, 1 / rate)
    shape = ((f > band[0]) & (f < band[1])) * 1.0
    spectrum = shape[:, None] * np.exp(2j * np.pi * rng.random((len(f), joints)))
    q = np.fft.irfft(spectrum / np.maximum(2 * np.pi * f, 1)[:, None] ** 2, samples, axis=0)
    ramp = np.minimum(1, np.minimum(np.arange(samples), np.arange(samples)[::-1]) / (0.5 * rate))
    smooth = (ramp**3 * (10 - 15 * ramp + 6 * ramp**2))[:, None]
    q = q * smooth
    F = np.fft.rfft(q, axis=0)
    v = np.fft.irfft(2j * np.pi * f[:, None] * F, samples, axis=0)
    a = np.fft.irfft(-((2 * np.pi * f[:, None]) ** 2) * F, samples, axis=0)
    scale = rms / a.std(axis=0)
    return a * scale, v * scale, q * scale


def tolerances(rng, arm_links, names, size=1.0):
    return {
        'k': {name: 1 + 0.015 * size * rng.standard_normal() for name in names},
        'c': {name: math.exp(0.08 * size * rng.standard_normal()) for name in names},
        'links': {
            link: {
                'mass': 1 + 0.01 * size * rng.standard_normal(),
                'com': 0.003 * size * rng.standard_normal(3),
                'inertia': 1 + 0.02 * size * rng.standard_normal(),
            }
            for link in arm_links
        },
        'mass_scale': 1 + 0.01 * size * rng.standard_normal(),
    }


def make_campaign(
    folder,
    effects=(),
    seed=0,
    n_fit=5,
    n_held=4,
    duration=32.0,
    noise=0.05,
    sensors=SENSORS,
    rms=(1.0,) * 6,
    size=1.0,
    levels=LEVELS,
    velocity=True,
):
    """Return the records of a campaign with these effects in the plant."""
    rng = np.random.default_rng(seed)
    nominal = read_arm(folder)
    names = [n for n in nominal.k if math.isfinite(nominal.k[n])]
    extra = tolerances(rng, list(nominal.frames), names, size)
    by = {}
    for effect in effects:
        by.setdefault(effect['type'], []).append(effect)
        structural(effect, extra, nominal)
    arm = read_arm(folder, extra)
    places, gains = [], []
    for _, link, position in sensors:
        places.append(
            (link, np.array(position) + 0.003 * size * rng.standard_normal(3), np.eye(3))
        )
        gains.append(1 + 0.007 * size * rng.standard_normal(3))
    gains = np.concatenate(gains)
    nonlinear = any(e['type'] in NONLINEAR for e in effects)
    # Explicit friction with a steep transition chatters in longer steps, which looks like a less
    # steep one; a preloaded spring, explicit as well, gets (ω h)² 5/12 stiffer.
    steps_per_s = 2000 if nonlinear else 1000
    if any(e.get('preload') for e in by.get('cubic_stiffness', [])):
        steps_per_s = 4000
    if any('friction' in kind for kind in by):
        steps_per_s = 16000
    dt = 1 / steps_per_s
    samples = int(duration / dt)
    cases = [
        (p, level, i >= n_fit)
        for i, p in enumerate(poses(rng, n_fit + n_held))
        for level in range(len(levels))
    ]
    motions = [
        excitation(rng, samples, 1 / dt, levels[level] * np.array(rms)) for _, level, _ in cases
    ]
    a, v, q = (np.array([m[i] for m in motions]) for i in range(3))
    reported_q, reported_v = q.copy(), v.copy()
    f = np.fft.rfftfreq(samples, dt)
    for e in by.get('command_delay', []):
        shift = np.exp(-2j * np.pi * f * e['delay'])[None, :, None]
        a, v, q = (
            np.fft.irfft(np.fft.rfft(s, axis=1) * shift, samples, axis=1) for s in (a, v, q)
        )
    systems = []
    for pose, _, _ in cases:
        systems.append(linearise(arm, pose, places))
    angle = np.array([pose for pose, _, _ in cases])[:, None, :] + q
    local = local_forces(effects, Plant(systems, arm, v, angle, dt, rng))
    y, _x, _xv = respond(systems, a, q, dt, local)
    y = sensor_faults(by, y, sensors, dt, rng)
    records = []
    keep, joint_keep = round(1 / dt / 500), round(1 / dt / 250)
    for r, (pose, level, held) in enumerate(cases):
        acc = y[r] * gains
        acc = decimated(acc, keep)
        acc = acc + noise * acc.std(axis=0) * rng.standard_normal(acc.shape)
        for e in by.get('clipping', []):
            limit = e['at'] * acc.std()
            acc = np.clip(acc, -limit, limit)
        records.append(
            HiddenRecord(
                f'p{r // len(levels)}_l{level}',
                pose,
                level,
                held,
                500.0,
                acc,
                250.0,
                pose + decimated(reported_q[r], joint_keep),
                decimated(reported_v[r], joint_keep),
            )
        )
    return records


def picked_up(folder, payload, seed, **options):
    """Return records in which the arm takes a payload at half time."""
    without, loaded = (make_campaign(folder, item, seed, **options) for item in ((), (payload,)))
    for record, other in zip(without, loaded, strict=True):
        half = len(record.acceleration) // 2
        record.acceleration[half:] = other.acceleration[half:]
    return without


def decimated(x, keep):
    f = np.fft.rfft(x, axis=0)
    n = len(x)
    limit = int(0.45 * n / keep)
    f[limit:] = 0
    return np.fft.irfft(f, n, axis=0)[::keep]


def structural(e, extra, arm):
    """Effects that change the linear plant."""
    kind = e['type']
    if kind == 'payload':
        extra.setdefault('masses', []).append(
            {
                'effect': 1,
                'link': e['link'],
                'mass_kg': e['mass'],
                'position_m': e['com'],
                'gyration_m': e.get('gyration', (0.05, 0.05, 0.05)),
            }
        )
    elif kind == 'joint_stiffness':
        extra['k'][f'{e["joint"]}/drive'] *= e['factor']
    elif kind == 'joint_damping':
        extra['c'][f'{e["joint"]}/drive'] *= e['factor']
    elif kind == 'base_compliance':
        c = e['compliance']
        extra['base'] = {
            'rx': (1 / c, e.get('loss', 4e-4) / c),
            'ry': (1 / c, e.get('loss', 4e-4) / c),
        }
    elif kind == 'link_flexibility':
        extra['hinge'] = {
            'link': e['link'],
            'at': e['at'],
            'axis': e['axis'],
            'k': 1 / e['compliance'],
            'c': 4e-4 / e['compliance'],
        }
    elif kind == 'tuned_mass':
        extra.setdefault('absorbers', []).append(
            {
                'link': e['link'],
                'position_m': e['at'],
                'axis': e['axis'],
                'mass': e['mass'],
                'f': e['f'],
                'zeta': e['zeta'],
            }
        )
    elif kind == 'servo_compliance':
        extra['servo'] = (2 * math.pi * e['f'], e['zeta'], e.get('feedforward', 1.0))
    elif kind == 'rod_spring':
        extra.setdefault('rods', []).append((e['weights'], e['k'], 3e-4 * e['k']))
    elif kind == 'sensor_mass':
        _name, link, place = next(s for s in SENSORS if s[0] == e['sensor'])
        extra.setdefault('masses', []).append(
            {'effect': 1, 'link': link, 'mass_kg': e['mass'], 'position_m': place}
        )


def tone(e, systems, place, dt, samples, rng):
    """A hum: torque in a joint, or force along an axis where a sensor sits; it may wander."""
    if 'sensor' in e:
        row = 3 * [name for name, _, _ in SENSORS].index(e['sensor']) + e['axis']
        push = np.array([s.Ja[row] for s in systems])
    else:
        push = np.zeros((len(systems), len(systems[0].M)))
        push[:, place[f'{e["joint"]}/drive']] = 1.0
    harmonics = e.get('harmonics', (1.0,))
    phase = rng.uniform(0, 2 * np.pi, (len(harmonics), len(systems)))
    turn = 2 * np.pi * e['f'] * dt * np.arange(samples)[:, None]
    if 'wander' in e:  # rad per root second
        turn = turn + e['wander'] * np.sqrt(dt) * np.cumsum(
            rng.standard_normal((samples, len(systems))), axis=0
        )
    else:
        turn = turn + np.zeros(len(systems))
    size = e['torque'] * sum(
        part * np.cos((order + 1) * turn + phase[order]) for order, part in enumerate(harmonics)
    )
    return slice(None), lambda t, x, xv: size[t][:, None] * push


def balance(alpha, load):
    """Return where a cubic spring carries what twists a linear one by this much."""
    roots = np.roots([alpha, 0.0, 1.0, -load])
    return min(roots[np.abs(roots.imag) < 1e-9].real, key=abs)


@dataclass(frozen=True)
class Plant:
    """What an explicit force may depend on, beside the deflections."""

    systems: list
    arm: object
    velocity: np.ndarray
    angle: np.ndarray
    dt: float
    rng: np.random.Generator

    @property
    def samples(self):
        return self.velocity.shape[1]

    @property
    def place(self):
        return {name: i for i, name in enumerate(self.systems[0].names)}

    def row(self, joint):
        return self.place[f'{joint}/drive']

    def axis(self, joint):
        return list(self.arm.joints).index(joint)

    def stiffness(self, joint):
        return self.arm.k[f'{joint}/drive']

    def sag(self, joint):
        """Return how far the weight twists a joint in each pose."""
        i = self.row(joint)
        return np.array([np.linalg.solve(s.K, s.load)[i] for s in self.systems])


def tonal_disturbance(e, plant):
    return [tone(e, plant.systems, plant.place, plant.dt, plant.samples, plant.rng)]


def transmission_error(e, plant):
    """The gear's output runs ahead of the motor by a ripple."""
    arm = plant.arm
    weights = arm.couple[plant.axis(e['joint'])]
    turned = e['order'] * arm.orders[e['joint']] * (plant.angle @ weights)
    push = plant.stiffness(e['joint']) * e['amplitude'] * np.sin(turned)
    push -= push[:, :1]
    return [
        (plant.row(arm.joints[number]), lambda t, x, xv, w=weight: w * push[:, t])
        for number, weight in enumerate(weights)
        if weight
    ]


def coulomb_friction(e, plant):
    i, j, v = plant.row(e['joint']), plant.axis(e['joint']), plant.velocity
    tc, v0 = e['torque'], e['v0']
    if e.get('total', False):
        return [(i, lambda t, x, xv: -tc * np.tanh((xv[:, i] + v[:, t, j]) / v0))]
    return [(i, lambda t, x, xv: -tc * np.tanh(xv[:, i] / v0))]


def stribeck_friction(e, plant):
    i = plant.row(e['joint'])
    tc, ts, vs, v0 = e['torque'], e['static'], e['speed'], 1e-3

    def slips(t, x, xv):
        rate = xv[:, i]
        return -(tc + (ts - tc) * np.exp(-((rate / vs) ** 2))) * np.tanh(rate / v0)

    return [(i, slips)]


def cubic_stiffness(e, plant):
    i, k, al = plant.row(e['joint']), plant.stiffness(e['joint']), e['alpha']
    load = e.get('preload', 0.0) * plant.sag(e['joint'])
    r = np.array([balance(al, value) for value in load])
    return [(i, lambda t, x, xv: -k * al * ((x[:, i] + r) ** 3 - r**3))]


def backlash(e, plant):
    i, k, b = plant.row(e['joint']), plant.stiffness(e['joint']), e['gap']
    x0 = e.get('preload', 1.0) * plant.sag(e['joint'])

    def play(z):
        return np.sign(z) * np.maximum(np.abs(z) - b, 0)

    # static position: on the flank gravity pushes to, in the middle when nothing pushes
    rest = x0 + b * np.sign(np.round(x0, 9))
    return [(i, lambda t, x, xv: k * x[:, i] - k * (play(x[:, i] + rest) - x0))]


def speed_dependent_stiffness(e, plant):
    i, j, v = plant.row(e['joint']), plant.axis(e['joint']), plant.velocity
    k, beta = plant.stiffness(e['joint']), e['beta']
    return [(i, lambda t, x, xv: -k * beta * np.abs(v[:, t, j]) * x[:, i])]


def drifting_stiffness(e, plant):
    i, k, r, dt = plant.row(e['joint']), plant.stiffness(e['joint']), e['rate'], plant.dt
    duration = plant.samples * dt
    return [(i, lambda t, x, xv: k * r * t * dt / duration * x[:, i])]


def end_stop(e, plant):
    i, gap, ks = plant.row(e['joint']), e['gap'], e['k']
    return [(i, lambda t, x, xv: -ks * np.sign(x[:, i]) * np.maximum(np.abs(x[:, i]) - gap, 0))]


def hysteresis(e, plant):
    i, limit = plant.row(e['joint']), e['limit']
    kh = e['share'] * plant.stiffness(e['joint'])
    state = {'s': np.zeros(len(plant.systems)), 'x': np.zeros(len(plant.systems))}

    def force(t, x, xv):
        state['s'] = np.clip(state['s'] + x[:, i] - state['x'], -limit, limit)
        state['x'] = x[:, i].copy()
        return -kh * state['s'] + 0.0

    return [(i, force)]


NONLINEAR = {
    each.__name__: each
    for each in (
        coulomb_friction,
        backlash,
        cubic_stiffness,
        speed_dependent_stiffness,
        hysteresis,
        stribeck_friction,
        end_stop,
        drifting_stiffness,
        tonal_disturbance,
        transmission_error,
    )
}
"""By kind: each returns pairs of rows and of the force on them, of (step, x, velocity of x)."""


def local_forces(effects, plant):
    """Explicit nonlinear or time-varying forces on the dofs."""
    terms = [
        term for e in effects if e['type'] in NONLINEAR for term in NONLINEAR[e['type']](e, plant)
    ]
    if not terms:
        return None

    def local(t, x, xv):
        out = np.zeros((len(x), len(plant.systems[0].M)))
        for i, term in terms:
            out[:, i] += term(t, x, xv)
        return out

    return local


def sensor_faults(by, y, sensors, dt, rng):
    names = [s[0] for s in sensors]
    f = np.fft.rfftfreq(y.shape[1], dt)

    def columns(e):
        s = names.index(e['sensor'])
        return slice(3 * s, 3 * s + 3)

    for e in by.get('sensor_gain', []):
        c = columns(e)
        axis = e.get('axis')
        if axis is None:
            y[:, :, c] *= e['gain']
        else:
            y[:, :, c.start + axis] *= e['gain']
    for e in by.get('sensor_polarity', []):
        y[:, :, columns(e).start + e['axis']] *= -1
    for e in by.get('sensor_axis_swap', []):
        s = columns(e).start
        i, j = s + e['axes'][0], s + e['axes'][1]
        y[:, :, [i, j]] = y[:, :, [j, i]]
    for e in by.get('sensor_rotation', []):
        axis = np.array(e['axis'], float)
        R = turn(axis / np.linalg.norm(axis), e['angle'])
        c = columns(e)
        y[:, :, c] = y[:, :, c] @ R.T
    for e in by.get('sensor_delay', []):
        c = columns(e)
        Y = np.fft.rfft(y[:, :, c], axis=1) * np.exp(-2j * np.pi * f * e['delay'])[None, :, None]
        y[:, :, c] = np.fft.irfft(Y, y.shape[1], axis=1)
    for e in by.get('sensor_mount_resonance', []):
        c = columns(e)
        r = f / e['f']
        H = (
            (1 + 2j * e['zeta'] * r) / (1 - r**2 + 2j * e['zeta'] * r)
            if e.get('base', False)
            else 1 / (1 - r**2 + 2j * e['zeta'] * r)
        )
        Y = np.fft.rfft(y[:, :, c], axis=1) * H[None, :, None]
        y[:, :, c] = np.fft.irfft(Y, y.shape[1], axis=1)
    for e in by.get('clock_drift', []):  # the sensors' clock runs fast
        time = dt * np.arange(y.shape[1])
        wanted = np.minimum(time * (1.0 + e['rate']), time[-1])
        y = CubicSpline(time, y, axis=1)(wanted)
    for e in by.get('loose_sensor', []):  # knocks and rings whenever it is shaken hard
        ring = np.arange(round(0.05 / dt)) * dt
        ring = np.exp(-ring / 0.01) * np.sin(2 * np.pi * e['f'] * ring)
        for record in y[:, :, columns(e)]:
            hard = np.abs(record).max(axis=1) > e['at'] * record.std()
            knocks = (hard[1:] & ~hard[:-1])[:, None] * rng.standard_normal((len(record) - 1, 3))
            record[1:] += (
                e['size'] * record.std() * fftconvolve(knocks, ring[:, None])[: len(record) - 1]
            )
    return y
