"""An arm simulated without the suite: own parser, own rigid-body recursion, own time stepping.

Used to hide effects from the workflow.  It shares no code with ``structural_model`` or
``model_gap``: the physics is written down a second time, from the same URDF and model.yaml.
"""

from dataclasses import dataclass, field
import math
from pathlib import Path
import xml.etree.ElementTree as ET

import numpy as np
import scipy.linalg
import yaml

EYE = np.eye(3)


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turn(axis, angle):
    S = cross_matrix(axis)
    return EYE + math.sin(angle) * S + (1 - math.cos(angle)) * S @ S


def rpy(angles):
    r, p, y = angles
    return turn(EYE[2], y) @ turn(EYE[1], p) @ turn(EYE[0], r)


def numbers(text, default='0 0 0'):
    return np.array([float(item) for item in (text or default).split()])


@dataclass
class Body:
    """A rigid piece: it rides on the first ``depth`` entries of the chain."""

    depth: int
    link: str
    mass: float
    com: np.ndarray
    inertia: np.ndarray


@dataclass
class Piece:
    """One entry of the chain: a placement, then possibly a turn or slide about an axis."""

    rotation: np.ndarray
    shift: np.ndarray
    axis: np.ndarray
    kind: str  # 'joint', 'spring' or 'slide'
    name: str


@dataclass
class Arm:
    """The arm as a chain (the robots shipped are serial), with its springs and extras."""

    pieces: list = field(default_factory=list)
    bodies: list = field(default_factory=list)
    joints: list = field(default_factory=list)
    k: dict = field(default_factory=dict)
    c: dict = field(default_factory=dict)
    alpha: float = 0.0
    beta: float = 0.0
    rods: list = field(default_factory=list)
    couple: np.ndarray = None
    frames: dict = field(default_factory=dict)  # link -> (depth, R, p) relative to the chain
    absorbers: list = field(default_factory=list)
    # Inertia behind the gear, rad/s, damping ratio, share of the inertia that is fed forward.
    motors: list = field(default_factory=list)


def across(axis):
    first = EYE[(int(np.argmax(np.abs(axis))) + 1) % 3]
    return first, np.cross(axis, first)


def read_arm(folder, extra=None):
    """Build the chain; ``extra`` changes numbers and inserts hinges."""
    extra = extra or {}
    tree = ET.parse(Path(folder) / 'robot.urdf').getroot()
    model = yaml.safe_load((Path(folder) / 'model.yaml').read_text())
    links = {item.get('name'): item for item in tree.findall('link')}
    joints = {item.find('parent').get('link'): item for item in tree.findall('joint')}
    arm = Arm()
    arm.alpha = float((model.get('damping') or {}).get('mass_proportional_1_s', 0))
    arm.beta = float((model.get('damping') or {}).get('stiffness_proportional_s', 0))
    own = (model.get('base') or {}).get('springs') or [{}] * 6
    for number, spring in enumerate(own):
        name = ('tx', 'ty', 'tz', 'rx', 'ry', 'rz')[number]
        k, c = float(spring.get('stiffness', math.inf)), float(spring.get('damping', 0))
        if name in extra.get('base', {}):  # a further compliance in series
            k2, c2 = extra['base'][name]
            c = c2 if math.isinf(k) else c * k2 / (k + k2)
            k = k2 if math.isinf(k) else k * k2 / (k + k2)
        if math.isfinite(k):
            key = f'base/{name}'
            arm.pieces.append(
                Piece(EYE, np.zeros(3), EYE[number % 3], 'slide' if number < 3 else 'spring', key)
            )
            arm.k[key], arm.c[key] = k * extra.get('k', {}).get(key, 1.0), c
    factors = {item['name']: item for item in model.get('links') or []}
    link = next(
        name
        for name in links
        if all(item.find('child').get('link') != name for item in tree.findall('joint'))
    )
    R, p = EYE, np.zeros(3)
    tolerance = extra.get('links', {})
    while True:
        inertial = links[link].find('inertial')
        hinge = extra.get('hinge')
        if inertial is not None:
            origin = inertial.find('origin')
            t = tolerance.get(link, {})
            known = factors.get(link, {})
            scale = t.get('mass', 1.0) * float(known.get('mass_factor', 1.0))
            mass = float(inertial.find('mass').get('value')) * scale
            com = numbers(origin.get('xyz') if origin is not None else None) + t.get('com', 0.0)
            com = com + np.array(known.get('com_shift_m', [0, 0, 0]), float)
            entries = inertial.find('inertia')
            g = [float(entries.get(n)) for n in ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')]
            inertia = np.array([[g[0], g[1], g[2]], [g[1], g[3], g[4]], [g[2], g[4], g[5]]])
            turned = rpy(numbers(origin.get('rpy'))) if origin is not None else EYE
            inertia = turned @ inertia @ turned.T * scale * t.get('inertia', 1.0)
            inertia = inertia * float(known.get('inertia_factor', 1.0))
            split = 0.5 if hinge and hinge['link'] == link else 1.0
            arm.bodies.append(
                Body(len(arm.pieces), link, split * mass, R @ com + p, split * R @ inertia @ R.T)
            )
            if split < 1.0:
                place = np.array(hinge['at'])
                arm.inner = (len(arm.pieces), R, p)
                arm.pieces.append(Piece(EYE, place, np.array(hinge['axis']), 'spring', 'hinge'))
                arm.k['hinge'], arm.c['hinge'] = hinge['k'], hinge['c']
                p = p - place
                arm.bodies.append(
                    Body(
                        len(arm.pieces), link, split * mass, R @ com + p, split * R @ inertia @ R.T
                    )
                )
        arm.frames[link] = (len(arm.pieces), R, p)
        if link not in joints:
            break
        joint = joints[link]
        origin = joint.find('origin')
        shift = numbers(origin.get('xyz') if origin is not None else None)
        Rj = rpy(numbers(origin.get('rpy') if origin is not None else None))
        link = joint.find('child').get('link')
        if joint.get('type') == 'fixed':
            R, p = R @ Rj, p + R @ shift
            continue
        name = joint.get('name')
        axis = numbers(joint.find('axis').get('xyz'))
        place, turned = p + R @ shift, R @ Rj
        data = (model.get('joints') or {}).get(name) or {}
        scale = extra.get('k', {})
        for number, (a, spring) in enumerate(
            zip(across(axis), data.get('tilts', [{}, {}]), strict=False), 1
        ):
            stiffness = float(spring.get('stiffness', math.inf))
            if math.isfinite(stiffness):
                key = f'{name}/tilt_{number}'
                arm.pieces.append(Piece(turned, place, a, 'spring', key))
                arm.k[key] = stiffness * scale.get(key, 1.0)
                arm.c[key] = float(spring.get('damping', 0.0))
                place, turned = np.zeros(3), EYE
        spring = data.get('drive') or {}
        key = f'{name}/drive'
        arm.k[key] = float(spring.get('stiffness', math.inf)) * scale.get(key, 1.0)
        arm.c[key] = float(spring.get('damping', 0.0))
        arm.pieces.append(Piece(turned, place, axis, 'joint', key))
        arm.joints.append(name)
        R, p = EYE, np.zeros(3)
    for item in (model.get('masses') or []) + extra.get('masses', []):
        depth, R, p = arm.frames[item['link']]
        m = float(item['mass_kg']) * (
            extra.get('mass_scale', 1.0) if 'effect' not in item else 1.0
        )
        gyration = np.array(item.get('gyration_m', [0, 0, 0]), float)
        arm.bodies.append(
            Body(
                depth,
                item['link'],
                m,
                R @ np.array(item['position_m'], float) + p,
                R @ np.diag(m * gyration**2) @ R.T,
            )
        )
    n = len(arm.joints)
    arm.couple = np.eye(n)
    for item in model.get('coupling') or []:
        arm.couple[arm.joints.index(item['axis']), arm.joints.index(item['added'])] += float(
            item.get('factor', 1.0)
        )
    arm.rods = extra.get('rods', [])
    arm.absorbers = extra.get('absorbers', [])
    arm.cscale = extra.get('c', {})
    if 'servo' in extra:
        for name in arm.joints:
            data = (model.get('joints') or {})[name]
            inertia = float(data['rotor_inertia_kg_m2']) * float(data['gear_ratio']) ** 2
            arm.motors.append((inertia, *extra['servo']))
    arm.orders = {
        name: float(((model.get('joints') or {}).get(name) or {}).get('gear_ratio', 1.0))
        for name in arm.joints
    }
    return arm


@dataclass
class Linear:
    """M x'' + C x' + K x = B a + P q at a pose; y = Ja x'' + Jg x + Ra a + Rg q."""

    names: list
    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    B: np.ndarray
    P: np.ndarray
    Ja: np.ndarray
    Jg: np.ndarray
    Ra: np.ndarray
    Rg: np.ndarray
    load: np.ndarray  # static gravity torque on every dof


def linearise(arm, q, sensors, gravity=9.81):
    """Assemble everything at a pose; ``sensors`` is a list of (link, position, 3x3 axes rows)."""
    names = [piece.name for piece in arm.pieces]
    R, p = EYE, np.zeros(3)
    frames, axes, points = [(R, p)], [], []
    number = 0
    for piece in arm.pieces:
        p = p + R @ piece.shift
        R = R @ piece.rotation
        axes.append(R @ piece.axis)
        points.append(p)
        if piece.kind == 'joint':
            R = R @ turn(piece.axis, q[number])
            number += 1
        frames.append((R, p))
    axes, points = np.array(axes), np.array(points)
    rotary = np.array([piece.kind != 'slide' for piece in arm.pieces])
    joint = np.array([piece.kind == 'joint' for piece in arm.pieces])
    n = len(names)

    def jac(depth, point):
        Jv, Jw = np.zeros((3, n)), np.zeros((3, n))
        for i in range(depth):
            if rotary[i]:
                Jv[:, i] = np.cross(axes[i], point - points[i])
                Jw[:, i] = axes[i]
            else:
                Jv[:, i] = axes[i]
        return Jv, Jw

    M, G = np.zeros((n, n)), np.zeros((n, n))
    load = np.zeros(n)
    g = np.array([0, 0, -gravity])
    for body in arm.bodies:
        Rb, pb = frames[body.depth]
        centre = Rb @ body.com + pb
        Jv, Jw = jac(body.depth, centre)
        M += body.mass * Jv.T @ Jv + Jw.T @ (Rb @ body.inertia @ Rb.T) @ Jw
        load += Jv.T @ g * body.mass
        for j in range(body.depth):
            for i in range(j + 1):
                if rotary[i]:
                    value = -body.mass * g @ np.cross(axes[i], Jv[:, j])
                    G[i, j] += value
                    G[j, i] += value if i != j else 0.0
    extra_rows = []
    for item in arm.absorbers:
        depth, Rl, pl = arm.frames[item['link']]
        Rb, pb = frames[depth]
        point = Rb @ (Rl @ np.array(item['position_m'], float) + pl) + pb
        Jv, _ = jac(depth, point)
        axis = Rb @ Rl @ np.array(item['axis'], float)
        extra_rows.append((item, Jv, axis))
    servo = n + len(extra_rows)
    size = servo + len(arm.motors)
    MM, KK, CC = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size))
    MM[:n, :n], KK[:n, :n] = M, G
    springs = np.zeros((size, size))
    for i, name in enumerate(names):
        if joint[i]:
            continue
        springs[i, i] = arm.k[name]
        CC[i, i] += arm.c[name]
    place = np.flatnonzero(joint)
    for number, (row, name) in enumerate(zip(arm.couple, arm.joints, strict=False)):
        w = np.zeros(size)
        w[place] = row
        if arm.motors:  # the gear twists between link and a motor that gives way
            inertia, omega, zeta, _ = arm.motors[number]
            w[servo + number] = -1.0
            MM[servo + number, servo + number] = inertia
            springs[servo + number, servo + number] += inertia * omega**2
            CC[servo + number, servo + number] += 2 * zeta * omega * inertia
        springs += arm.k[f'{name}/drive'] * np.outer(w, w)
        CC += arm.c[f'{name}/drive'] * np.outer(w, w)
    for weights, k, c in arm.rods:
        w = np.zeros(size)
        for name, value in weights.items():
            w[names.index(f'{name}/drive')] = value
        springs += k * np.outer(w, w)
        CC += c * np.outer(w, w)
    for number, (item, Jv, axis) in enumerate(extra_rows):
        row, m = n + number, item['mass']
        MM[:n, :n] += m * Jv.T @ Jv
        MM[row, :n] = MM[:n, row] = m * axis @ Jv
        MM[row, row] = m
        springs[row, row] = m * (2 * math.pi * item['f']) ** 2
        CC[row, row] = 2 * item['zeta'] * m * 2 * math.pi * item['f']
    CC += arm.alpha * MM + arm.beta * np.where(
        np.arange(size)[:, None] < n, np.where(np.arange(size) < n, springs, 0), 0
    )
    # Damping tolerance and changes: every spring's share, material part included.
    for i, name in enumerate(names):
        factor = arm.cscale.get(name, 1.0) - 1.0
        if factor:
            w = np.zeros(size)
            if joint[i]:
                w[place] = arm.couple[list(place).index(i)]
            else:
                w[i] = 1.0
            CC += factor * (arm.c[name] + arm.beta * arm.k[name]) * np.outer(w, w)
    KK += springs
    B = -MM[:, place]
    for number, (inertia, _, _, fed) in enumerate(arm.motors):
        B[servo + number] -= (1.0 - fed) * inertia * arm.couple[number]
    P = -np.vstack([G[:, place], np.zeros((size - n, len(place)))])
    rows = []
    for link, position, basis in sensors:
        depth, Rl, pl = arm.frames[link]
        Rb, pb = frames[depth]
        point = Rb @ (Rl @ np.array(position, float) + pl) + pb
        Jv, Jw = jac(depth, point)
        S = basis @ (Rb @ Rl).T
        # reading = S (a - g); turning by theta changes -S g to first order by S (theta x g)
        rows.append((S @ Jv, S @ (-cross_matrix(g)) @ Jw))
    Ja = np.vstack([row[0] for row in rows])
    Jg = np.vstack([row[1] for row in rows])
    pad = np.zeros((len(Ja), size - n))
    return Linear(
        names,
        MM,
        CC,
        KK,
        B,
        P,
        np.hstack([Ja, pad]),
        np.hstack([Jg, pad]),
        Ja[:, place],
        Jg[:, place],
        np.r_[load, np.zeros(size - n)],
    )


def held(A, dt):
    """Phi and integrals for inputs linear between samples (augmented exponential)."""
    n = len(A)
    Z = np.zeros((3 * n, 3 * n))
    Z[:n, :n], Z[:n, n : 2 * n], Z[n : 2 * n, 2 * n :] = A * dt, eye_of(n) * dt, eye_of(n)
    E = scipy.linalg.expm(Z)
    return E[:n, :n], E[:n, n : 2 * n], E[:n, 2 * n :]


def eye_of(n):
    return np.eye(n)


def respond(systems, motor_a, motor_q, dt, local=None):
    """Step all records together.

    systems: one Linear per record; motor_a, motor_q: (records, samples, joints).
    local(t_index, x, v) -> (records, n) extra force on the dofs, explicit; or None.
    Returns acceleration readings (records, samples, channels) and deflection histories.
    """
    count, samples = motor_a.shape[:2]
    n = len(systems[0].M)
    Phi, G0, G1, Minv = [], [], [], []
    for s in systems:
        Mi = np.linalg.inv(s.M)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-Mi @ s.K, -Mi @ s.C]])
        f, g0, g1 = held(A, dt)
        Phi.append(f)
        G0.append(g0[:, n:] @ Mi)
        G1.append(g1[:, n:] @ Mi)
        Minv.append(Mi)
    Phi, G0, G1, Minv = map(np.array, (Phi, G0, G1, Minv))
    force = np.array(
        [a @ s.B.T + q @ s.P.T for s, a, q in zip(systems, motor_a, motor_q, strict=False)]
    )
    step = np.diff(force, axis=1, append=force[:, -1:])
    drive = np.einsum('rij,rtj->rti', G0, force) + np.einsum('rij,rtj->rti', G1, step)
    z = np.zeros((count, 2 * n, 1))
    history = np.zeros((samples, count, 2 * n))
    added = np.zeros((samples, count, n))
    for t in range(samples):
        history[t] = z[:, :, 0]
        new = Phi @ z + drive[:, t, :, None]
        if local is not None:
            extra = local(t, z[:, :n, 0], z[:, n:, 0])
            added[t] = extra
            change = extra - added[t - 1] if t else np.zeros_like(extra)
            new = new + G0 @ extra[:, :, None] + G1 @ change[:, :, None]
        z = new
    x, v = history[..., :n].transpose(1, 0, 2), history[..., n:].transpose(1, 0, 2)
    out = []
    for r, s in enumerate(systems):
        total = force[r] + added[:, r] - v[r] @ s.C.T - x[r] @ s.K.T
        acc = total @ Minv[r].T
        out.append(acc @ s.Ja.T + x[r] @ s.Jg.T + motor_a[r] @ s.Ra.T + motor_q[r] @ s.Rg.T)
    return np.array(out), x, v
