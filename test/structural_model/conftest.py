"""Small arms with known answers, written as robot folders."""

import numpy as np
import pytest

from structural_model import load_layout, load_robot


class Arms:
    """Writes robot folders below a temporary one."""

    def __init__(self, folder):
        self.folder = folder

    @staticmethod
    def link(name, mass, com='0 0 0', inertia=(1e-9, 1e-9, 1e-9)):
        ixx, iyy, izz = inertia
        return (
            f'<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass!r}"/>'
            f'<inertia ixx="{ixx!r}" iyy="{iyy!r}" izz="{izz!r}" ixy="0" ixz="0" iyz="0"/>'
            '</inertial></link>'
        )

    @staticmethod
    def joint(name, parent, child, xyz='0 0 0', axis='0 1 0', kind='revolute'):
        limit = '<limit lower="-3.1" upper="3.1" velocity="2" effort="100"/>'
        moving = '' if kind == 'fixed' else f'<axis xyz="{axis}"/>{limit}'
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{xyz}"/>{moving}</joint>'
        )

    def write(self, body, model_yaml='{}'):
        (self.folder / 'robot.urdf').write_text(f'<robot name="arm">{body}</robot>')
        (self.folder / 'model.yaml').write_text(model_yaml)
        return self.folder

    def load(self, body, model_yaml='{}'):
        return load_robot(self.write(body, model_yaml))

    def pendulum(self, model_yaml, mass=3.0, arm=0.8, inertia=0.2, kind='revolute', axis='0 1 0'):
        """A body ``arm`` above its joint at q = 0."""
        body = '<link name="base"/>' + self.link(
            'rod', mass, f'0 0 {arm}', (inertia, inertia, 0.01)
        )
        return self.load(body + self.joint('j', 'base', 'rod', kind=kind, axis=axis), model_yaml)


@pytest.fixture
def arms(tmp_path):
    return Arms(tmp_path)


@pytest.fixture(scope='session', params=['irb6660_205_190', 'generic_arm_6'])
def shipped(request):
    """Model and full layout of every shipped robot."""
    return load_robot(request.param), load_layout(request.param)


@pytest.fixture
def poses():
    """Return seeded poses inside a robot's limits."""

    def draw(model, count, seed):
        rng = np.random.default_rng(seed)
        limits = model.limits
        found = []
        while len(found) < count:
            low = np.clip(limits.controller_low, -3.0, 3.0)
            high = np.clip(limits.controller_high, -3.0, 3.0)
            low = np.where(np.isfinite(low), low, -3.0)
            high = np.where(np.isfinite(high), high, 3.0)
            q = model.to_serial(rng.uniform(low, high))
            if limits.position_violation(q) is None:
                found.append(q)
        return np.array(found)

    return draw
