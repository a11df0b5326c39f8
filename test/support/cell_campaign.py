"""Campaigns of the independent arm in a cell that its model does not know.

An arm on a foundation that swings, with a cable to the ground or a counterbalance, joints that
stand elsewhere than recorded, sensors elsewhere or turned; gravity is in the readings.
"""

from unittest import mock

import numpy as np
from scipy.spatial.transform import Rotation

from test.support import hidden_campaign, independent_arm
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.independent_arm import Body, Chain, Piece

G = 9.81
EYE = np.eye(3)


def cell_campaign(folder, seed, *cell, mount_deg=0.5, gravity=True, effects=(), **options):
    """Return hidden records of a cell.

    Parameters
    ----------
    folder : path
        Of the robot.
    seed : int
        Of tolerances, poses, motion and noise.
    cell : dict
        What is in it: ``kind`` and its numbers.
    mount_deg : float [deg]
        Of every sensor's mount, rms about each axis.
    gravity : bool
        Whether accelerometers show it.
    effects, options
        As of ``make_campaign``.
    """
    rng = np.random.default_rng([seed, 4711])
    mounts = [
        Rotation.from_rotvec(np.radians(mount_deg) * rng.standard_normal(3)) for _ in SENSORS
    ]
    turned = [item.get('turned', {}) for item in cell]
    means = []

    def read_arm(folder, extra=None):
        arm = independent_arm.read_arm(folder, extra)
        for item in cell:
            if item['kind'] == 'foundation_mode':
                put_on_foundation(arm, item)
        return arm

    def linearise(arm, pose, places):
        pose, places = standing(pose, cell), list(places)
        for number, (link, place, axes) in enumerate(places):
            extra = next((t[SENSORS[number][0]] for t in turned if SENSORS[number][0] in t), EYE)
            places[number] = link, place, extra @ mounts[number].as_matrix() @ axes
        found = independent_arm.linearise(arm, pose, places)
        chain = Chain(arm, pose)
        for item in cell:
            if item['kind'] == 'cable':
                add_cable(chain, found, item)
            if item['kind'] == 'gravity_compensator':
                add_compensator(arm, found, pose, item)
        means.append(
            np.concatenate([b @ chain.on_link(k, p)[2].T @ [0, 0, G] for k, p, b in places])
        )
        return found

    own = {'cubic_damping': cubic_damping, 'load_friction': load_friction}
    laws = {**hidden_campaign.NONLINEAR, **own}
    changed = {'read_arm': read_arm, 'linearise': linearise, 'NONLINEAR': laws}
    with mock.patch.multiple(hidden_campaign, **changed):
        sensors = [(name, link, moved(name, at, cell)) for name, link, at in SENSORS]
        records = make_campaign(folder, effects, seed, sensors=sensors, **options)
    for record, mean in zip(records, means, strict=True):
        if gravity:
            record.acceleration = record.acceleration + mean
    return records


def cubic_damping(e, plant):
    i, c = plant.row(e['joint']), e['c']
    return [(i, lambda t, x, xv: -c * xv[:, i] ** 3)]


def load_friction(e, plant):
    """Coulomb's, and a part of the whole torque in the spring, weight included."""
    i, k, r = plant.row(e['joint']), plant.stiffness(e['joint']), plant.sag(e['joint'])
    return [
        (
            i,
            lambda t, x, xv: (
                -(e['torque'] + e['share'] * abs(k * (r + x[:, i]))) * np.tanh(xv[:, i] / e['v0'])
            ),
        )
    ]


def standing(pose, cell):
    """Return where the joints really are."""
    pose = np.array(pose, float)
    for item in cell:
        if item['kind'] == 'encoder_offset':
            pose[int(item['joint'][-1]) - 1] += item['offset']
    return pose


def moved(name, at, cell):
    shift = sum(
        np.array(c['shift'])
        for c in cell
        if (c['kind'], c.get('sensor')) == ('sensor_position', name)
    )
    return tuple(np.array(at) + shift)


def put_on_foundation(arm, item):
    """Put a body on springs under the arm; ``along`` lists the ways it moves."""
    names, count = [], len(item['along'])
    for way in item['along']:
        kind, axis = ('slide' if way[0] == 't' else 'spring'), EYE['xyz'.index(way[1])]
        names.append(Piece(EYE, np.zeros(3), axis, kind, f'foundation/{way}'))
        own = item['mass'] if way[0] == 't' else item['mass'] * item['gyration'] ** 2
        stiffness = own * (2 * np.pi * item['f']) ** 2
        arm.k[f'foundation/{way}'] = stiffness
        arm.c[f'foundation/{way}'] = 2 * item['zeta'] * stiffness / (2 * np.pi * item['f'])
    arm.pieces[:0] = names
    for body in arm.bodies:
        body.depth += count
    arm.frames = {link: (depth + count, R, p) for link, (depth, R, p) in arm.frames.items()}
    inertia = item['mass'] * item['gyration'] ** 2 * EYE
    arm.bodies.append(Body(count, 'foundation', item['mass'], np.zeros(3), inertia))


def add_cable(chain, system, item):
    """Pull a point of a link towards a point of the ground."""
    depth, point, _ = chain.on_link(item['link'], item['at'])
    Jv, _ = chain.jacobian(depth, point)
    way = np.array(item['anchor'], float) - point
    row = way / np.linalg.norm(way) @ Jv
    n = chain.n
    system.K[:n, :n] += item['k'] * np.outer(row, row)
    system.P[:n] -= item['k'] * np.outer(row, row[chain.place])


def add_compensator(arm, system, pose, item):
    joint = arm.joints.index(item['joint'])
    row = system.names.index(f'{item["joint"]}/drive')
    slope = item['strength'] * np.cos(pose[joint] - item['phase'])
    system.K[row, row] += slope
    system.P[row, joint] -= slope
