"""How far an arm reaches, and where a point of it is, counted by hand."""

import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from model_gap.cell import CellModel
from model_gap.effects import Scene
from model_gap.effects.places import on_link, reach, turned, turns
from structural_model import load_robot

LINK = (
    '<link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="9"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
)
JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{before}"/><child link="{link}"/>'
    '<origin xyz="{place}"/><axis xyz="0 1 0"/>'
    '<limit lower="-0.2" upper="0.5" velocity="3" effort="9"/></joint>'
)
MODEL = """
robot_name: two
joints:
  pan: {drive: {stiffness: 4.0e4}}
  tilt: {drive: {stiffness: 5.0e4}}
"""


@pytest.mark.parametrize(
    ('kind', 'sensors', 'expected'),
    [
        ('revolute', (), 0.4 + 0.5 + 0.45),
        ('revolute', (Sensor('tip', 'boom', (0.95, 0.0, 0.0)),), 0.4 + 0.5 + 0.95),
        ('prismatic', (), 0.4 + 0.5 + 0.5 + 0.45),
    ],
)
def test_the_last_link_and_what_is_on_it_belong_to_the_reach(tmp_path, kind, sensors, expected):
    assert reach(scene_of(tmp_path, kind, sensors)) == pytest.approx(expected)


def test_a_point_of_one_link_in_the_axes_of_the_next(tmp_path):
    """The boom stands 0.3 m out and 0.4 m up, turned about y by a quarter."""
    scene = scene_of(tmp_path, 'revolute', ())
    pose = np.array([0.7, np.pi / 2.0])
    assert on_link(scene, (0.2, 0.1, 0.0), 'boom', 'column', pose) == pytest.approx(
        (0.3, 0.1, 0.4 - 0.2)
    )
    assert on_link(scene, (0.3, 0.1, 0.2), 'column', 'boom', pose) == pytest.approx(
        (0.2, 0.1, 0.0), abs=1e-12
    )


@pytest.mark.parametrize('axis', ['x', 'y', 'z'])
def test_an_axis_is_turned_to_lie_along_any_line(axis):
    seed = 7
    for along in np.random.default_rng(seed).standard_normal((20, 3)):
        along /= np.linalg.norm(along)
        found = np.array(turned(axis, turns(axis, along)))
        assert abs(found @ along) == pytest.approx(1.0), f'seed {seed}: {along}'


def scene_of(tmp_path, kind, sensors):
    parts = [
        LINK.format(name=name, x=x) for name, x in (('base', 0), ('column', 0), ('boom', 0.45))
    ]
    parts.append(
        JOINT.format(name='pan', kind='revolute', before='base', link='column', place='0 0 0.4')
    )
    parts.append(
        JOINT.format(name='tilt', kind=kind, before='column', link='boom', place='0.3 0 0.4')
    )
    (tmp_path / 'robot.urdf').write_text(f'<robot name="two">{"".join(parts)}</robot>')
    (tmp_path / 'model.yaml').write_text(MODEL)
    model = load_robot(str(tmp_path))
    cell = CellModel(model.spec, SensorLayout(sensors).channels)
    return Scene(model, (), cell)
