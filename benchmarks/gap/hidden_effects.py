"""What the matrix of hidden effects hides: each kind with numbers from its plausible range."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Site:
    """Where an effect may sit, and the generator its numbers come from."""

    rng: np.random.Generator
    joint: str
    low: str  # one of the joints that carry most
    sensor: str
    sign: float


def site_of(rng, sensor_names):
    return Site(
        rng,
        joint=f'joint_{rng.integers(1, 6)}',
        low=f'joint_{rng.integers(1, 4)}',
        sensor=str(rng.choice(sensor_names)),
        sign=rng.choice([-1.0, 1.0]),
    )


def draw(kind, rng, sensor_names):
    """Return one effect of a kind with numbers from its plausible range."""
    site = site_of(rng, sensor_names)
    if kind == 'picked_up_payload':  # a payload, with a site of its own
        return payload(site_of(rng, sensor_names))
    return DRAWN[kind](site)


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def payload(s):
    com = s.rng.uniform(-0.15, 0.15, 3)
    return {'link': 'flange', 'mass': s.rng.uniform(8, 60), 'com': com}


def joint_stiffness(s):
    return {'joint': s.joint, 'factor': float(np.exp(s.sign * s.rng.uniform(0.15, 0.6)))}


def joint_damping(s):
    return {'joint': s.low, 'factor': float(np.exp(s.rng.uniform(0.7, 1.6)))}


def base_compliance(s):
    return {'compliance': log_uniform(s.rng, 5e-9, 1e-7)}


def link_flexibility(s):
    link, at = [('link_2', (0, 0, 0.35)), ('link_4', (0.4, 0, 0))][s.rng.integers(2)]
    axis = (0, 1, 0) if link == 'link_2' else [(0, 1, 0), (0, 0, 1)][s.rng.integers(2)]
    return {'link': link, 'at': at, 'axis': axis, 'compliance': s.rng.uniform(5e-8, 4e-7)}


def rod_spring(s):
    # The sum is what the third drive acts on, by its own rod: a stiffer joint.
    return {'weights': {'joint_2': 1, 'joint_3': -1.0}, 'k': s.rng.uniform(2e5, 2e6)}


def tuned_mass(s):
    axis = (0, 0, 1) if s.rng.integers(2) else (0, 1, 0)
    link = ['link_3', 'link_4'][s.rng.integers(2)]
    return {
        'link': link,
        'at': (0.2, 0, 0.1) if link == 'link_3' else (0.4, 0, 0),
        'axis': axis,
        'mass': s.rng.uniform(6, 25),
        'f': s.rng.uniform(7, 30),
        'zeta': s.rng.uniform(0.02, 0.1),
    }


def coulomb_friction(s):
    return {'joint': s.low, 'torque': s.rng.uniform(60, 250), 'v0': 1e-3}


def backlash(s):
    return {'joint': s.low, 'gap': s.rng.uniform(3e-5, 2e-4), 'preload': 1.0}


def cubic_stiffness(s):
    return {'joint': s.low, 'alpha': log_uniform(s.rng, 3e5, 4e6)}


def speed_dependent_stiffness(s):
    return {'joint': s.low, 'beta': float(s.sign * s.rng.uniform(1, 4))}


def tonal_disturbance(s):
    return {'joint': s.low, 'f': s.rng.uniform(8, 50), 'torque': s.rng.uniform(50, 250)}


def transmission_error(s):
    return {'joint': s.low, 'amplitude': s.rng.uniform(1e-4, 4e-4), 'order': 1.0}


def servo_compliance(s):
    fed = float(s.rng.integers(2))
    return {'f': s.rng.uniform(15, 60), 'zeta': s.rng.uniform(0.3, 0.9), 'feedforward': fed}


def command_delay(s):
    return {'delay': s.rng.uniform(0.003, 0.015)}


def sensor_gain(s):
    return {'sensor': s.sensor, 'gain': float(np.exp(s.sign * s.rng.uniform(0.08, 0.6)))}


def sensor_polarity(s):
    return {'sensor': s.sensor, 'axis': int(s.rng.integers(3))}


def sensor_axis_swap(s):
    return {'sensor': s.sensor, 'axes': [(0, 1), (0, 2), (1, 2)][s.rng.integers(3)]}


def sensor_rotation(s):
    axis = s.rng.standard_normal(3)
    return {'sensor': s.sensor, 'axis': axis, 'angle': s.rng.uniform(0.08, 0.6)}


def sensor_delay(s):
    return {'sensor': s.sensor, 'delay': float(s.sign * s.rng.uniform(0.001, 0.01))}


def sensor_mount_resonance(s):
    base = bool(s.rng.integers(2))
    return {'sensor': s.sensor, 'f': s.rng.uniform(65, 160), 'zeta': 0.05, 'base': base}


def sensor_mass(s):
    return {'sensor': ['elbow', 'spindle'][s.rng.integers(2)], 'mass': s.rng.uniform(2, 3)}


def hysteresis(s):
    share = s.rng.uniform(0.2, 0.5)
    return {'joint': s.low, 'share': share, 'limit': s.rng.uniform(2e-5, 8e-5)}


def drifting_stiffness(s):
    return {'joint': s.low, 'rate': s.rng.uniform(0.1, 0.3)}


def end_stop(s):
    return {'joint': s.low, 'gap': s.rng.uniform(5e-5, 1.5e-4), 'k': 8e6}


def stribeck_friction(s):
    torque = s.rng.uniform(60, 150)
    static = torque * s.rng.uniform(1.5, 2.5)
    return {'joint': s.low, 'torque': torque, 'static': static, 'speed': 5e-3}


def clock_drift(s):
    return {'rate': float(s.sign * s.rng.uniform(6e-5, 2e-4))}


def loose_sensor(s):
    return {'sensor': s.sensor, 'f': s.rng.uniform(40, 90), 'at': 1.5, 'size': 1.0}


def clipping(s):
    return {'at': s.rng.uniform(1.0, 2.0)}


DRAWN = {
    each.__name__: each
    for each in (
        payload,
        joint_stiffness,
        joint_damping,
        base_compliance,
        link_flexibility,
        rod_spring,
        tuned_mass,
        coulomb_friction,
        backlash,
        cubic_stiffness,
        speed_dependent_stiffness,
        transmission_error,
        tonal_disturbance,
        servo_compliance,
        command_delay,
        sensor_gain,
        sensor_polarity,
        sensor_axis_swap,
        sensor_rotation,
        sensor_delay,
        sensor_mount_resonance,
        sensor_mass,
        hysteresis,
        drifting_stiffness,
        end_stop,
        clipping,
        stribeck_friction,
        clock_drift,
        loose_sensor,
    )
}
"""By kind."""
