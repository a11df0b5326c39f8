"""The flexible arm integrated without any linearisation, and seen by kinematics of its own."""

import numpy as np
import pinocchio as pin


class ReferenceArm:
    """Runge-Kutta over mass matrix and inverse dynamics of the expanded arm.

    Shares pinocchio and the robot's description with the plant, and nothing else.
    """

    def __init__(self, model, motion, gears=None):
        assembly, spec = model.assembly, model.spec
        self.model, self.motion, self.gears = model, motion, gears
        self.tree, self.data = assembly.model, assembly.model.createData()
        self.flexible, self.drives = assembly.flexible, assembly.drives
        self.stiffness, self.damping = assembly.stiffness, assembly.damping
        self.mass_damping = spec.damping.mass_proportional_1_s
        self.spring = np.array([joint.drive.spring.stiffness for joint in spec.joints])
        self.twist = np.zeros((6, model.n_dof))
        for axis, row in enumerate(model.axes.matrix):
            for joint, weight in zip(model.joint_names, row, strict=True):
                self.twist[axis, model.dof_names.index(f'{joint}/drive')] = weight

    def gear_torque(self, x, speed):
        gears = self.gears
        if gears is None:
            return np.zeros(6)
        y, rate = self.twist @ x, self.twist @ speed
        wound = np.sign(y) * np.maximum(np.abs(y) - gears.backlash_rad, 0.0)
        torque = self.spring * (wound + np.array(gears.hardening_1_rad2) * wound**3 - y)
        return torque + gears.friction_nm * np.tanh(rate / gears.friction_speed_rad_s)

    def acceleration(self, time_s, x, speed):
        full = np.zeros((3, self.tree.nv))
        full[:, self.drives] = self.motion(time_s)
        full[0, self.flexible] += x
        full[1, self.flexible] += speed
        torque = pin.rnea(self.tree, self.data, *full)[self.flexible]
        upper = np.triu(pin.crba(self.tree, self.data, full[0]))
        mass = (upper + np.triu(upper, 1).T)[np.ix_(self.flexible, self.flexible)]
        force = -torque - self.stiffness @ x - self.damping @ speed
        force -= self.mass_damping * mass @ speed + self.twist.T @ self.gear_torque(x, speed)
        return np.linalg.solve(mass, force)

    def run(self, x, n_samples, step_s, substeps):
        """Return x, x' and x'' at the end of every sample, from rest."""
        speed, h, found = np.zeros(len(x)), step_s / substeps, []
        for number in range(n_samples * substeps):
            t = number * h
            a = self.acceleration(t, x, speed)
            b = self.acceleration(t + h / 2, x + h / 2 * speed, speed + h / 2 * a)
            c = self.acceleration(t + h / 2, x + h / 2 * speed + h * h / 4 * a, speed + h / 2 * b)
            d = self.acceleration(t + h, x + h * speed + h * h / 2 * b, speed + h * c)
            x = x + h * speed + h * h / 6 * (a + b + c)
            speed = speed + h / 6 * (a + 2 * b + 2 * c + d)
            if (number + 1) % substeps == 0:
                found.append((x, speed, self.acceleration(t + h, x, speed)))
        return tuple(np.array(part) for part in zip(*found, strict=True))


def turn(axis, angle):
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def place_of_sensor(model, joint, placement, full):
    """Return rotation and position of a sensor in the world, (3, 3) and (3,): no pinocchio."""
    tree = model.assembly.model
    rotation, position = np.array(placement.rotation), np.array(placement.translation)
    while joint:
        kind, angle = tree.joints[joint].shortname(), full[tree.joints[joint].idx_v]
        axis = {'X': (1, 0, 0), 'Y': (0, 1, 0), 'Z': (0, 0, 1)}.get(kind[-1])
        axis = np.array(tree.joints[joint].extract().axis if axis is None else axis, float)
        if kind.startswith('JointModelR'):
            rotation, position = turn(axis, angle) @ rotation, turn(axis, angle) @ position
        else:
            position = position + axis * angle
        here = tree.jointPlacements[joint]
        rotation = np.array(here.rotation) @ rotation
        position = np.array(here.rotation) @ position + np.array(here.translation)
        joint = int(tree.parents[joint])
    return rotation, position
