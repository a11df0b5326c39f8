"""Encoder campaigns of a made-up arm, by recursive Newton-Euler of its own: no pinocchio.

Planar to read, spatial to compute: every link is a body with a mass, a centre and an inertia on
an axis; torques follow from forces, friction from a LuGre bristle, the gear from a spring.
"""

import numpy as np
from scipy.spatial.transform import Rotation

RATE_HZ = 250.0
GRAVITY = np.array([0.0, 0.0, 9.81])


def smooth_motion(n_joints, seed, duration_s=10.0, size_rad=0.45, terms=4):
    """Return times and angles that begin and end at rest, up to half a hertz, (n, n_joints)."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(duration_s * RATE_HZ) + 1) / RATE_HZ
    phase = np.clip((time - 0.8) / (duration_s - 1.6), 0.0, 1.0)
    window = np.sin(np.pi * phase) ** 4
    angles = []
    for _ in range(n_joints):
        weights = rng.normal(size=(2, terms)) / np.sqrt(terms)
        turns = 2.0 * np.pi * np.outer(phase, np.arange(1, terms + 1))
        angles.append(
            size_rad * window * (np.sin(turns) @ weights[0] + np.cos(turns) @ weights[1])
        )
    return time, np.array(angles).T


def newton_euler(links, q, qd, qdd):
    """Return the torques about z of every link's frame, (n, n_links) [N m].

    Parameters
    ----------
    links : list of dict
        ``place`` (3,), ``turn`` (3, 3) of the joint in the frame before; ``mass``, ``centre``,
        ``inertia`` (3, 3) about the centre.
    q, qd, qdd : (n, n_links) array
        Motion.
    """
    count = len(q)
    axis = np.array([0.0, 0.0, 1.0])
    spin = np.zeros((count, 3))
    turned = np.zeros((count, 3))
    lifted = np.tile(GRAVITY, (count, 1))
    frames, states = [], []
    for number, link in enumerate(links):
        into = Rotation.from_matrix(link['turn']) * Rotation.from_rotvec(
            np.outer(q[:, number], axis)
        )
        place = np.asarray(link['place'])
        lifted = lifted + np.cross(turned, place) + np.cross(spin, np.cross(spin, place))
        back = into.inv()
        lifted = back.apply(lifted)
        before = back.apply(spin)
        spin = before + np.outer(qd[:, number], axis)
        turned = (
            back.apply(turned)
            + np.outer(qdd[:, number], axis)
            + np.cross(before, np.outer(qd[:, number], axis))
        )
        centre, inertia = np.asarray(link['centre']), np.asarray(link['inertia'])
        drag = (lifted + np.cross(turned, centre) + np.cross(spin, np.cross(spin, centre))) * link[
            'mass'
        ]
        twist = turned @ inertia + np.cross(spin, spin @ inertia) + np.cross(centre, drag)
        frames.append((into, place))
        states.append((drag, twist))
    torque = np.zeros((count, len(links)))
    force, moment = np.zeros((count, 3)), np.zeros((count, 3))
    for number in reversed(range(len(links))):
        drag, twist = states[number]
        force, moment = force + drag, moment + twist
        torque[:, number] = moment[:, 2]
        into, place = frames[number]
        force = into.apply(force)
        moment = into.apply(moment) + np.cross(place, force)
    return torque


def bristle(speed, coulomb, width, dt):
    """Return LuGre's friction without its viscous part, (n,): dz/dt = v - |v| z / width."""
    state, found = 0.0, np.empty_like(speed)
    for place, now in enumerate(speed):
        # Implicit, so that any speed is stable.
        state = (state + now * dt) / (1.0 + abs(now) * dt / width)
        found[place] = coulomb * state / width
    return found


def links_of(model):
    """Return the arm of a robot's URDF as plain numbers, of every moving joint."""
    arm = model.robot.model
    found = []
    for joint in range(1, arm.njoints):
        place, inertia = arm.jointPlacements[joint], arm.inertias[joint]
        found.append(
            {
                'place': np.array(place.translation),
                'turn': np.array(place.rotation),
                'mass': inertia.mass,
                'centre': np.array(inertia.lever),
                'inertia': np.array(inertia.inertia),
            }
        )
    return found


def with_payload(link, mass, place):
    """Return a link with a point mass in its frame."""
    total = link['mass'] + mass
    centre = (link['mass'] * link['centre'] + mass * place) / total

    def about(amount, arm):
        return amount * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    inertia = (
        link['inertia']
        + about(link['mass'], link['centre'] - centre)
        + about(mass, place - centre)
    )
    return {**link, 'mass': total, 'centre': centre, 'inertia': inertia}


def record(model, start, hidden, seed, duration_s=10.0, noise=(2e-6, 3.0)):
    """Return the arrays of one recording of an arm with laws its model lacks.

    Parameters
    ----------
    model : FlexibleJointModel
        Of which only the URDF's numbers, gear ratios and rotors are used.
    start : (n_joints,) array [rad]
        Where the positions are zero.
    hidden : dict
        ``coulomb``, ``viscous``, ``stiffness`` by joint number; ``compensator`` (joint, strength,
        phase); ``payload`` (mass, place); ``delay``.
    seed : int
        Of motion and noise.
    noise : (float, float)
        Of a position [rad] and of a torque behind the gear [N m], every sample.
    """
    rng = np.random.default_rng([*np.atleast_1d(seed), 1])
    time, motor = smooth_motion(model.n_joints, seed, duration_s)
    dt = 1.0 / RATE_HZ
    speed, acceleration = np.gradient(motor, dt, axis=0), None
    acceleration = np.gradient(speed, dt, axis=0)
    links = links_of(model)
    if 'payload' in hidden:
        links[-1] = with_payload(links[-1], *hidden['payload'])
    load = newton_euler(links, motor + start, speed, acceleration)
    if 'compensator' in hidden:
        joint, strength, phase = hidden['compensator']
        load[:, joint] += strength * np.sin(motor[:, joint] + start[joint] - phase)
    ratio = np.array([item.drive.gear_ratio for item in model.spec.joints])
    rotor = np.array([item.drive.rotor_inertia_kg_m2 for item in model.spec.joints])
    torque = load + ratio**2 * rotor * acceleration
    for joint, level in hidden.get('coulomb', {}).items():
        torque[:, joint] += bristle(speed[:, joint], level, 1e-4, dt)
    for joint, damping in hidden.get('viscous', {}).items():
        torque[:, joint] += damping * speed[:, joint]
    link = np.zeros_like(motor)
    for joint, stiffness in hidden.get('stiffness', {}).items():
        true = motor[:, joint] - load[:, joint] / stiffness
        late = np.interp(time - hidden.get('delay', 0.0), time, true)
        link[:, joint] = late + noise[0] * rng.normal(size=len(time))
    torque = torque + noise[1] * rng.normal(size=torque.shape)
    return {
        'time_s': time,
        'motor_position_rad': motor + noise[0] * rng.normal(size=motor.shape) * 0.0,
        'link_position_rad': link,
        'motor_torque_nm': torque / ratio,
    }


def write(folder, recordings):
    """Write recordings as a campaign."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, arrays in recordings.items():
        np.savez(folder / f'{name}.npz', **arrays)
    return folder
