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
    damping = model.get('damping') or {}
    arm = Arm()
    arm.alpha = float(damping.get('mass_proportional_1_s', 0))
    arm.beta = float(damping.get('stiffness_proportional_s', 0))
    add_base(arm, model, extra)
    add_chain(arm, tree, model, extra)
    add_masses(arm, model, extra)
    arm.couple = coupling(arm.joints, model)
    arm.rods = extra.get('rods', [])
    arm.absorbers = extra.get('absorbers', [])
    arm.cscale = extra.get('c', {})
    data = model.get('joints') or {}
    if 'servo' in extra:
        for name in arm.joints:
            ratio = float(data[name]['gear_ratio'])
            inertia = float(data[name]['rotor_inertia_kg_m2']) * ratio**2
            arm.motors.append((inertia, *extra['servo']))
    arm.orders = {
        name: float((data.get(name) or {}).get('gear_ratio', 1.0)) for name in arm.joints
    }
    return arm


def add_base(arm, model, extra):
    """Springs below the first link; a further compliance comes in series."""
    own = (model.get('base') or {}).get('springs') or [{}] * 6
    for number, spring in enumerate(own):
        name = ('tx', 'ty', 'tz', 'rx', 'ry', 'rz')[number]
        k, c = float(spring.get('stiffness', math.inf)), float(spring.get('damping', 0))
        if name in extra.get('base', {}):
            k2, c2 = extra['base'][name]
            c = c2 if math.isinf(k) else c * k2 / (k + k2)
            k = k2 if math.isinf(k) else k * k2 / (k + k2)
        if math.isfinite(k):
            key = f'base/{name}'
            kind = 'slide' if number < 3 else 'spring'
            arm.pieces.append(Piece(EYE, np.zeros(3), EYE[number % 3], kind, key))
            arm.k[key], arm.c[key] = k * extra.get('k', {}).get(key, 1.0), c


def add_chain(arm, tree, model, extra):
    """Links and joints from the base to the tip."""
    links = {item.get('name'): item for item in tree.findall('link')}
    joints = {item.find('parent').get('link'): item for item in tree.findall('joint')}
    factors = {item['name']: item for item in model.get('links') or []}
    link = root_of(links, tree)
    R, p = EYE, np.zeros(3)
    while True:
        inertial = links[link].find('inertial')
        if inertial is not None:
            tolerance = extra.get('links', {}).get(link, {})
            body = inertia_of(inertial, tolerance, factors.get(link, {}))
            p = add_link(arm, link, body, R, p, extra.get('hinge'))
        arm.frames[link] = (len(arm.pieces), R, p)
        if link not in joints:
            return
        joint = joints[link]
        link = joint.find('child').get('link')
        shift, turned = placed(joint.find('origin'))
        p, R = p + R @ shift, R @ turned
        if joint.get('type') != 'fixed':
            add_joint(arm, joint, model, extra.get('k', {}), R, p)
            R, p = EYE, np.zeros(3)


def root_of(links, tree):
    children = {item.find('child').get('link') for item in tree.findall('joint')}
    return next(name for name in links if name not in children)


def placed(origin):
    """Return shift and rotation of an origin; none is no shift."""
    if origin is None:
        return np.zeros(3), rpy(np.zeros(3))
    return numbers(origin.get('xyz')), rpy(numbers(origin.get('rpy')))


def inertia_of(inertial, tolerance, known):
    """Return mass, centre and inertia about it of a link, with its tolerances."""
    origin = inertial.find('origin')
    scale = tolerance.get('mass', 1.0) * float(known.get('mass_factor', 1.0))
    mass = float(inertial.find('mass').get('value')) * scale
    com = numbers(origin.get('xyz') if origin is not None else None) + tolerance.get('com', 0.0)
    com = com + np.array(known.get('com_shift_m', [0, 0, 0]), float)
    entries = inertial.find('inertia')
    g = [float(entries.get(n)) for n in ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')]
    inertia = np.array([[g[0], g[1], g[2]], [g[1], g[3], g[4]], [g[2], g[4], g[5]]])
    turned = rpy(numbers(origin.get('rpy'))) if origin is not None else EYE
    inertia = turned @ inertia @ turned.T * scale * tolerance.get('inertia', 1.0)
    return mass, com, inertia * float(known.get('inertia_factor', 1.0))


def add_link(arm, link, body, R, p, hinge):
    """Add a link's body, in two halves where a hinge divides it; return the new origin."""
    mass, com, inertia = body
    split = 0.5 if hinge and hinge['link'] == link else 1.0

    def add(p):
        arm.bodies.append(
            Body(len(arm.pieces), link, split * mass, R @ com + p, split * R @ inertia @ R.T)
        )

    add(p)
    if split == 1.0:
        return p
    place = np.array(hinge['at'])
    arm.inner = (len(arm.pieces), R, p)
    arm.pieces.append(Piece(EYE, place, np.array(hinge['axis']), 'spring', 'hinge'))
    arm.k['hinge'], arm.c['hinge'] = hinge['k'], hinge['c']
    add(p - place)
    return p - place


def add_joint(arm, joint, model, scale, turned, place):
    """Add the tilts of a joint that give way, then its drive."""
    name = joint.get('name')
    axis = numbers(joint.find('axis').get('xyz'))
    data = (model.get('joints') or {}).get(name) or {}
    tilts = data.get('tilts', [{}, {}])
    for number, (a, spring) in enumerate(zip(across(axis), tilts, strict=False), 1):
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


def add_masses(arm, model, extra):
    for item in (model.get('masses') or []) + extra.get('masses', []):
        depth, R, p = arm.frames[item['link']]
        scale = extra.get('mass_scale', 1.0) if 'effect' not in item else 1.0
        m = float(item['mass_kg']) * scale
        gyration = np.array(item.get('gyration_m', [0, 0, 0]), float)
        com = R @ np.array(item['position_m'], float) + p
        arm.bodies.append(Body(depth, item['link'], m, com, R @ np.diag(m * gyration**2) @ R.T))


def coupling(joints, model):
    """Return which axes each drive turns."""
    couple = np.eye(len(joints))
    for item in model.get('coupling') or []:
        row, column = joints.index(item['axis']), joints.index(item['added'])
        couple[row, column] += float(item.get('factor', 1.0))
    return couple


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


class Chain:
    """The chain at a pose: frames after each piece, and the axes it gives way about."""

    def __init__(self, arm, q):
        R, p = EYE, np.zeros(3)
        self.arm = arm
        self.frames, axes, points = [(R, p)], [], []
        angles = iter(q)
        for piece in arm.pieces:
            p = p + R @ piece.shift
            R = R @ piece.rotation
            axes.append(R @ piece.axis)
            points.append(p)
            if piece.kind == 'joint':
                R = R @ turn(piece.axis, next(angles))
            self.frames.append((R, p))
        self.axes, self.points = np.array(axes), np.array(points)
        self.rotary = np.array([piece.kind != 'slide' for piece in arm.pieces])
        self.joint = np.array([piece.kind == 'joint' for piece in arm.pieces])
        self.place = np.flatnonzero(self.joint)
        self.n = len(arm.pieces)

    def jacobian(self, depth, point):
        """Return velocity of a point and rate of its body by the rates of the pieces."""
        Jv, Jw = np.zeros((3, self.n)), np.zeros((3, self.n))
        for i in range(depth):
            if self.rotary[i]:
                Jv[:, i] = np.cross(self.axes[i], point - self.points[i])
                Jw[:, i] = self.axes[i]
            else:
                Jv[:, i] = self.axes[i]
        return Jv, Jw

    def on_link(self, link, position):
        """Return depth, point and axes of a place on a link."""
        depth, Rl, pl = self.arm.frames[link]
        Rb, pb = self.frames[depth]
        return depth, Rb @ (Rl @ np.array(position, float) + pl) + pb, Rb @ Rl


def linearise(arm, q, sensors, gravity=9.81):
    """Assemble everything at a pose; ``sensors`` is a list of (link, position, 3x3 axes rows)."""
    chain = Chain(arm, q)
    n, place = chain.n, chain.place
    g = np.array([0, 0, -gravity])
    M, G, load = rigid_matrices(chain, g)
    servo = n + len(arm.absorbers)
    size = servo + len(arm.motors)
    MM, KK, CC = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size))
    MM[:n, :n], KK[:n, :n] = M, G
    springs = np.zeros((size, size))
    add_springs(chain, springs, CC)
    add_drives(chain, MM, springs, CC, servo)
    add_rods(arm, springs, CC)
    add_absorbers(chain, MM, springs, CC)
    CC += arm.alpha * MM + arm.beta * np.where(
        np.arange(size)[:, None] < n, np.where(np.arange(size) < n, springs, 0), 0
    )
    scale_damping(chain, CC)
    KK += springs
    B = -MM[:, place]
    for number, (inertia, _, _, fed) in enumerate(arm.motors):
        B[servo + number] -= (1.0 - fed) * inertia * arm.couple[number]
    P = -np.vstack([G[:, place], np.zeros((size - n, len(place)))])
    Ja, Jg = readings(chain, sensors, g)
    pad = np.zeros((len(Ja), size - n))
    return Linear(
        [piece.name for piece in arm.pieces],
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


def rigid_matrices(chain, g):
    """Return mass matrix, stiffness of the weight and its load, of the pieces."""
    n = chain.n
    M, G, load = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    for body in chain.arm.bodies:
        Rb, pb = chain.frames[body.depth]
        Jv, Jw = chain.jacobian(body.depth, Rb @ body.com + pb)
        M += body.mass * Jv.T @ Jv + Jw.T @ (Rb @ body.inertia @ Rb.T) @ Jw
        load += Jv.T @ g * body.mass
        for j in range(body.depth):
            for i in range(j + 1):
                if chain.rotary[i]:
                    value = -body.mass * g @ np.cross(chain.axes[i], Jv[:, j])
                    G[i, j] += value
                    G[j, i] += value if i != j else 0.0
    return M, G, load


def add_springs(chain, springs, CC):
    for i, piece in enumerate(chain.arm.pieces):
        if not chain.joint[i]:
            springs[i, i] = chain.arm.k[piece.name]
            CC[i, i] += chain.arm.c[piece.name]


def add_drives(chain, MM, springs, CC, servo):
    """Add every drive's spring; with motors, the gear twists between link and one of them."""
    arm = chain.arm
    for number, (row, name) in enumerate(zip(arm.couple, arm.joints, strict=False)):
        w = np.zeros(len(MM))
        w[chain.place] = row
        if arm.motors:
            inertia, omega, zeta, _ = arm.motors[number]
            w[servo + number] = -1.0
            MM[servo + number, servo + number] = inertia
            springs[servo + number, servo + number] += inertia * omega**2
            CC[servo + number, servo + number] += 2 * zeta * omega * inertia
        springs += arm.k[f'{name}/drive'] * np.outer(w, w)
        CC += arm.c[f'{name}/drive'] * np.outer(w, w)


def add_rods(arm, springs, CC):
    names = [piece.name for piece in arm.pieces]
    for weights, k, c in arm.rods:
        w = np.zeros(len(springs))
        for name, value in weights.items():
            w[names.index(f'{name}/drive')] = value
        springs += k * np.outer(w, w)
        CC += c * np.outer(w, w)


def add_absorbers(chain, MM, springs, CC):
    n = chain.n
    for row, item in enumerate(chain.arm.absorbers, n):
        depth, point, turned = chain.on_link(item['link'], item['position_m'])
        Jv, _ = chain.jacobian(depth, point)
        axis, m = turned @ np.array(item['axis'], float), item['mass']
        MM[:n, :n] += m * Jv.T @ Jv
        MM[row, :n] = MM[:n, row] = m * axis @ Jv
        MM[row, row] = m
        springs[row, row] = m * (2 * math.pi * item['f']) ** 2
        CC[row, row] = 2 * item['zeta'] * m * 2 * math.pi * item['f']


def scale_damping(chain, CC):
    """Damping tolerance and changes: every spring's share, material part included."""
    arm = chain.arm
    for i, piece in enumerate(arm.pieces):
        factor = arm.cscale.get(piece.name, 1.0) - 1.0
        if factor:
            w = np.zeros(len(CC))
            if chain.joint[i]:
                w[chain.place] = arm.couple[list(chain.place).index(i)]
            else:
                w[i] = 1.0
            own = arm.c[piece.name] + arm.beta * arm.k[piece.name]
            CC += factor * own * np.outer(w, w)


def readings(chain, sensors, g):
    """Return what sensors read by acceleration and, through the weight, by position."""
    rows = []
    for link, position, basis in sensors:
        depth, point, turned = chain.on_link(link, position)
        Jv, Jw = chain.jacobian(depth, point)
        S = basis @ turned.T
        # reading = S (a - g); turning by theta changes -S g to first order by S (theta x g)
        rows.append((S @ Jv, S @ (-cross_matrix(g)) @ Jw))
    return np.vstack([row[0] for row in rows]), np.vstack([row[1] for row in rows])


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
