"""A robot of a URDF alone: which arm, what is guessed, and that it can be used."""

import math

import numpy as np
import pinocchio as pin
import pytest

from abb_emulator.run_plan import ArmOptions, run_plan
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.errors import ModelError
from modal_recordings import open_recording
from structural_model import first_robot, load_layout, load_robot

SEED = 3
MESH = '<collision><geometry><mesh filename="package://a/b.stl"/></geometry></collision>'
LENGTHS = (0.3, 0.4, 0.35, 0.2, 0.12, 0.1, 0.08)
AXES = ('0 0 1', '0 1 0', '0 1 0', '1 0 0', '0 1 0', '1 0 0', '0 0 1')


def bar(name, mass, length, thick=0.08):
    """A link: a box of even density above its joint, drawn as a mesh."""
    across = mass * (length**2 + thick**2) / 12.0
    along = mass * thick**2 / 6.0
    return (
        f'<link name="{name}">{MESH}<visual/><inertial><origin xyz="0 0 {length / 2}"/>'
        f'<mass value="{mass}"/><inertia ixx="{across}" iyy="{across}" izz="{along}" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link>'
    )


def joint(name, parent, child, z, axis='0 1 0', kind='revolute', limit='', more=''):
    limit = limit or 'lower="-2.8" upper="2.8" velocity="2" effort="200"'
    moving = '' if kind == 'fixed' else f'<axis xyz="{axis}"/><limit {limit}/>'
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="0 0 {z}"/><parent link="{parent}"/>'
        f'<child link="{child}"/>{moving}{more}</joint>'
    )


def urdf(folder, n_joints=6, more='', limits=None):
    """An arm of so many joints with a hand of two fingers, the second one coupled."""
    body = '<link name="base"/>'
    before, z = 'base', 0.2
    for number in range(n_joints):
        name = f'link_{number + 1}'
        limit = (limits or {}).get(number, '')
        body += bar(name, 12.0 / (number + 1), LENGTHS[number])
        body += joint(f'j{number + 1}', before, name, z, AXES[number], limit=limit)
        before, z = name, LENGTHS[number]
    slide = 'lower="0" upper="0.04" velocity="0.1" effort="20"'
    body += bar('hand', 0.5, 0.05) + joint('mount', before, 'hand', z, kind='fixed')
    for side, coupled in (('left', ''), ('right', '<mimic joint="finger_left"/>')):
        body += bar(side, 0.02, 0.04, 0.01)
        body += joint(f'finger_{side}', 'hand', side, 0.05, '0 1 0', 'prismatic', slide, coupled)
    file = folder / 'arm.urdf'
    file.write_text(f'<robot name="arm">{body}{more}</robot>')
    return file


def write(made, folder):
    folder.mkdir()
    for name, content in made.files.items():
        (folder / name).write_bytes(content)
    return folder


def test_fingers_stand_still_and_the_folder_is_a_robot(tmp_path):
    made = first_robot(urdf(tmp_path))
    assert made.arm.joints == ('j1', 'j2', 'j3', 'j4', 'j5', 'j6')
    assert made.arm.standing == ('finger_left', 'finger_right')
    assert (made.arm.base, made.arm.tip) == ('base', 'hand')
    model = load_robot(write(made, tmp_path / 'robot'))
    assert model.joint_names == made.arm.joints
    layout = load_layout(tmp_path / 'robot')
    model.check_layout(layout)
    assert len(layout.channels) == 3 * 7
    modes = model.modes(model.pose('home'), layout.channels)
    assert np.all(modes.frequency_hz > 0.0)
    assert modes.damping_ratio[0] == pytest.approx(0.02, rel=0.1)


def test_known_frequency_is_met(tmp_path):
    for lowest_hz in (4.0, 25.0):
        model = first_robot(urdf(tmp_path), lowest_hz=lowest_hz).model
        found = model.modes(model.pose('home')).frequency_hz[0]
        assert found == pytest.approx(lowest_hz, rel=0.005)
    with pytest.raises(ModelError, match='not a frequency'):
        first_robot(urdf(tmp_path), lowest_hz=0.0)


def test_a_mesh_becomes_the_box_that_has_its_inertia(tmp_path):
    made = first_robot(urdf(tmp_path))
    (shape,) = (item for item in made.model.robot.shapes if item.link == 'link_2')
    assert sorted(shape.box) == pytest.approx([0.08, 0.08, LENGTHS[1]], rel=1e-3)
    assert shape.position == pytest.approx([0.0, 0.0, LENGTHS[1] / 2.0])
    along = np.abs(shape.rotation[:, int(np.argmax(shape.box))])
    assert along == pytest.approx([0.0, 0.0, 1.0], abs=1e-4)


def test_home_is_bent_and_a_plan_is_possible(tmp_path):
    model = first_robot(urdf(tmp_path)).model
    home = model.pose('home')
    assert np.abs(home).max() > 0.1, 'stretched out no joint shakes the arm about its own line'
    plan = plan_excitation(model, None, PlanRequest(duration_s=4.0, seed=SEED))
    assert plan.torque_projection_rank == 3


def test_what_the_urdf_leaves_open_is_assumed_and_told(tmp_path):
    none = 'lower="-2.8" upper="2.8" velocity="0" effort="0"'
    made = first_robot(urdf(tmp_path, limits={1: none}))
    said = ' '.join(made.guessed)
    assert 'largest speed of j2: the URDF gives none' in said
    assert 'largest torque of j2: the URDF gives none' in said
    robot = made.model.robot
    weight = pin.computeGeneralizedGravity(
        robot.model, robot.model.createData(), np.array([0.0, math.pi / 2.0, 0.0, 0.0, 0.0, 0.0])
    )
    assert made.model.limits.effort[1] > abs(weight[1]), 'it can hold itself'


def test_branches_ask_for_the_tip(tmp_path):
    other = ''
    before = 'base'
    for number in range(3):
        other += bar(f'other_{number}', 1.0, 0.2)
        other += joint(f'o{number}', before, f'other_{number}', 0.2)
        before = f'other_{number}'
    file = urdf(tmp_path, more=other)
    with pytest.raises(ModelError, match='name the last link') as error:
        first_robot(file)
    assert 'other_0' in str(error.value)
    assert first_robot(file, tip='other_2').arm.joints == ('o0', 'o1', 'o2')
    assert len(first_robot(file, tip='hand').arm.joints) == 6
    with pytest.raises(ModelError, match='unknown link'):
        first_robot(file, tip='nothing')


def test_an_axis_of_the_arm_that_follows_another_one_is_refused(tmp_path):
    file = urdf(tmp_path)
    text = file.read_text().replace('</joint>', '<mimic joint="j1"/></joint>', 2)
    file.write_text(text.replace('<mimic joint="j1"/></joint>', '</joint>', 1))
    with pytest.raises(ModelError, match='unsupported joint') as error:
        first_robot(file)
    assert 'joint j2' in str(error.value)


@pytest.mark.parametrize('n_joints', [3, 7])
def test_an_arm_of_any_number_of_joints_is_recorded(tmp_path, n_joints):
    folder = write(first_robot(urdf(tmp_path, n_joints)), tmp_path / 'robot')
    model, layout = load_robot(folder), load_layout(folder)
    asked = {'duration_s': 4.0, 'acceleration_rms': 0.5, 'signal': 'band_limited_noise',
             'require_full_rank': False, 'seed': SEED}  # fmt: skip
    plan = plan_excitation(model, layout, PlanRequest.from_mapping(asked))
    last = model.joint_names[-1]
    friction = {'type': 'coulomb_friction', 'joint': last, 'torque': 1.0}
    options = ArmOptions.from_mapping({'robot': str(folder), 'effects': [friction]})
    played = run_plan(options, plan, tmp_path / 'run.mcap')
    info = open_recording(played.path).info()
    assert {topic.name: topic.n_messages for topic in info.topics}['/joint_states'] > 100
