"""Robot folders: what ships, the parallel rod, and one clear line for every bad file."""

import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from modal_core.errors import LayoutError, ModelError
from structural_model import load_layout, load_robot
from structural_model.model_notes import model_notes
from structural_model.robot_files import robot_folder

DEG = np.pi / 180


def one_line(error) -> str:
    text = str(error.value)
    assert '\n' not in text and len(text) < 600
    return text


def test_wrist_centre_at_p1_needs_the_coupling():
    """Published check: (1.626, 1.740) m with coupled angles, (1.687, 1.027) m when serial."""
    model = load_robot('irb6660_205_190')
    wrist = [('link_5', np.zeros(3))]
    coupled = model.geometry.positions([model.pose('P1')], wrist)[0, 0]
    np.testing.assert_allclose(coupled, [1.626, 0.0, 1.740], atol=6e-4)
    serial = np.array([0, 45, -10, 90, -90, 0]) * DEG
    np.testing.assert_allclose(
        model.geometry.positions([serial], wrist)[0, 0], [1.687, 0.0, 1.027], atol=6e-4
    )


def test_controller_and_serial_angles_both_ways():
    model = load_robot('irb6660_205_190')
    controller = np.array([10.0, 45.0, -10.0, 90.0, -90.0, 5.0]) * DEG
    serial = model.to_serial(controller)
    assert serial[2] == pytest.approx(-55.0 * DEG)
    np.testing.assert_allclose(np.delete(serial, 2), np.delete(controller, 2))
    np.testing.assert_allclose(model.to_controller(serial), controller, atol=1e-15)
    many = np.tile(controller, (4, 1))
    np.testing.assert_allclose(model.to_controller(model.to_serial(many)), many, atol=1e-15)


def test_power_is_the_same_on_both_sides_of_the_rod():
    model = load_robot('irb6660_205_190')
    rng = np.random.default_rng(5)
    q, qd, qdd = rng.normal(size=(3, 6)) * 0.3
    serial = model.torque(q, qd, qdd)
    drive = model.drive_torque(q, qd, qdd)
    assert serial @ qd == pytest.approx(drive @ model.to_controller(qd), rel=1e-12)


def test_published_kinematic_facts():
    model = load_robot('irb6660_205_190')
    limits = model.limits
    np.testing.assert_allclose(
        limits.controller_low / DEG, [-180, -42, -20, -300, -120, -360], atol=1e-6
    )
    np.testing.assert_allclose(
        limits.controller_high / DEG, [180, 85, 120, 300, 120, 360], atol=1e-6
    )
    np.testing.assert_allclose(limits.position_high[2] / DEG, 70.0, atol=1e-6)
    np.testing.assert_allclose(limits.velocity / DEG, [130, 130, 130, 150, 120, 190])
    total = sum(inertia.mass for inertia in model.robot.model.inertias)
    assert total == pytest.approx(1730.0, abs=20.0)


def test_pose_outside_the_axis_and_the_coupled_range():
    model = load_robot('irb6660_205_190')
    with pytest.raises(ModelError) as error:
        model.check_pose(model.to_serial(np.array([0, 90, 90, 0, 0, 0]) * DEG))
    assert 'axis range of axis_2' in one_line(error) and '90.000 deg' in one_line(error)
    with pytest.raises(ModelError) as error:
        model.check_pose(model.to_serial(np.array([0, -20, 100, 0, 0, 0]) * DEG))
    text = one_line(error)
    assert 'coupled range of joint_3' in text and '120.000 deg' in text and '70.000' in text


@pytest.mark.parametrize('bad', [[0.0] * 5, [np.nan] * 6, 0.0])
def test_wrong_joint_vector(bad):
    with pytest.raises(ModelError):
        load_robot('generic_arm_6').check_pose(bad)


def test_layouts_sit_on_the_robot(shipped):
    model, layout = shipped
    layout.check_links(model.link_names, model.robot_name)
    assert len(layout.sensors) == 14 and len(layout.channels) == 42
    light = load_layout(model.robot_name, 'sensors_light')
    light.check_links(model.link_names, model.robot_name)
    assert 3 <= len(light.sensors) <= 6


def test_shipped_poses_are_inside_the_limits_and_free_of_collision(shipped):
    model, _ = shipped
    for name in model.poses_controller_rad:
        q = model.check_pose(model.pose(name))
        assert model.geometry.clearance(q).distance_m > 0.02, name


@pytest.mark.parametrize('name', ['nonsense', '../irb6660_205_190', '', 'a' * 300])
def test_unknown_robot_or_layout(name):
    with pytest.raises(ModelError) as error:
        load_robot(name) if name else load_layout('generic_arm_6', '../sensors')
    assert 'unknown' in one_line(error)


def test_unknown_pose_link_and_parameter():
    model = load_robot('generic_arm_6')
    with pytest.raises(ModelError, match='unknown pose'):
        model.pose('P9')
    from modal_core.channel import Channel

    with pytest.raises(ModelError, match='unknown link'):
        model.sensor_jacobian(model.pose('home'), [Channel('x', 'elbow_typo')])
    for name in ('joints.a9.drive.spring.stiffness', 'nothing', 'joints.a1.drive.spring', ''):
        with pytest.raises(ModelError, match='unknown model parameter'):
            model.with_parameters({name: 1.0})


URDF_FAULTS = {
    'link without inertia': '<link name="b"/><link name="l"/>{joint}',
    'mass above zero': '<link name="b"/><link name="l"><inertial><mass value="0"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>{joint}',
    'mass is negative': '<link name="b"/><link name="l"><inertial><mass value="-1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>{joint}',
    'a xacro that is not expanded': '<link name="b"/><link name="l"/>{joint}'
    '<x:include xmlns:x="http://www.ros.org/wiki/xacro" filename="a"/>',
    'inertia no body can have': '<link name="b"/><link name="l"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="9" ixy="0" ixz="0" iyz="0"/></inertial></link>{joint}',
    'bad numbers': '<link name="b"/><link name="l"><inertial><mass value="1e400"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>{joint}',
    'no moving joint': '<link name="b"/>',
    'inertial without mass or inertia': '<link name="b"/><link name="l"><inertial>'
    '<mass value="1"/></inertial></link>{joint}',
}


@pytest.mark.parametrize('fault', sorted(URDF_FAULTS))
def test_bad_urdf(arms, fault):
    body = URDF_FAULTS[fault].replace('{joint}', arms.joint('j', 'b', 'l'))
    with pytest.raises(ModelError) as error:
        arms.load(body)
    assert fault in one_line(error)


def test_frames_fixed_to_a_body_may_have_odd_inertias(arms):
    """Real files have tool frames of mass zero and cameras whose moments no body has."""
    body = '<link name="base"/>' + arms.link('rod', 1.0, inertia=(0.2, 0.2, 0.01))
    body += arms.joint('j', 'base', 'rod')
    for name, mass, inertia in (('tool0', 0.0, (0, 0, 0)), ('camera', 0.01, (1e-6, 1e-6, 1e-3))):
        body += arms.link(name, mass, inertia=inertia)
        body += arms.joint(f'to_{name}', 'rod', name, kind='fixed')
    model = arms.load(body)
    (moving,) = list(model.robot.model.inertias)[1:]
    assert moving.mass == pytest.approx(1.01)
    assert model.link_names == ('base', 'rod', 'tool0', 'camera')


def test_links_are_in_order_from_base_to_tip_whatever_the_file_says(arms):
    """Published files have `world` last; a tool, a payload and the flange go by the last link."""
    parts = [
        arms.link('arm', 1.0), arms.link('camera', 0.1), '<link name="tool0"/>',
        arms.link('rod', 1.0), '<link name="base"/>', '<link name="world"/>',
        arms.joint('tool', 'arm', 'tool0', kind='fixed'), arms.joint('j2', 'rod', 'arm'),
        arms.joint('eye', 'rod', 'camera', kind='fixed'), arms.joint('j1', 'base', 'rod'),
        arms.joint('floor', 'world', 'base', kind='fixed'),
    ]  # fmt: skip
    model = arms.load(''.join(parts))
    assert model.link_names == ('world', 'base', 'rod', 'camera', 'arm', 'tool0')
    assert model.joint_names == ('j1', 'j2')


HEAVY = (
    '<inertial><origin xyz="{}" rpy="{}"/><mass value="5"/>'
    '<inertia ixx="1" iyy="1" izz="1"/></inertial>'
)


@pytest.mark.parametrize('which', ['xyz', 'rpy'])
@pytest.mark.parametrize(
    'text',
    ['0,1 0 0', '', 'nan 0 0', '1 2', '1_0 0 0', '\u0661 0 0', '1e308 0 0', '0x1 0 0'],
)
def test_a_place_that_cannot_be_read_costs_no_link_its_mass(arms, capfd, which, text):
    """Pinocchio's parser drops such an inertia, and shows its text to the terminal as it is."""
    good = {'xyz': '0 0 0', 'rpy': '0 0 0'}
    tool = '<link name="tool">{}</link><joint name="f" type="fixed"><parent link="rod"/>'
    tool += '<child link="tool"/></joint>'
    body = '<link name="base"/>' + arms.link('rod', 1.0) + arms.joint('j', 'base', 'rod')
    whole = arms.load(body + tool.format(HEAVY.format(*good.values())))
    assert sum(part.mass for part in whole.robot.model.inertias) == pytest.approx(6.0)
    bad = {**good, which: text}
    with pytest.raises(ModelError, match='bad numbers') as error:
        arms.load(body + tool.format(HEAVY.format(*bad.values())))
    assert 'tool' in one_line(error)
    assert capfd.readouterr() == ('', '')


def test_what_no_model_needs_of_a_urdf_is_not_read(arms, capfd):
    body = '<link name="base"/>' + arms.link('rod', 1.0) + arms.joint('j', 'base', 'rod')
    odd = '<dynamics damping="x"/><safety_controller k_velocity="x"/></joint>'
    model = arms.load(body.replace('</joint>', odd) + '<material name="m"/><material name="m"/>')
    assert model.joint_names == ('j',)
    assert capfd.readouterr() == ('', '')


@pytest.mark.parametrize(
    ('old', 'new', 'fault'),
    [
        ('type="revolute"', 'type="planar"', 'unsupported joint'),
        ('<limit lower="-3.1" upper="3.1"', '<limit lower="2" upper="1"', 'joint range is empty'),
        ('<limit lower="-3.1" upper="3.1" velocity="2" effort="100"/>', '', 'no limit'),
        ('xyz="0 1 0"', 'xyz="0 0 0"', 'joint axis is zero'),
        ('xyz="0 1 0"', 'xyz="0 one 0"', 'bad numbers'),
        ('<child link="rod"/>', '<child link="ghost"/>', 'child of a joint is not a link'),
        ('<link name="base"/>', '<link name="base"/><link name="other"/>', 'not one tree'),
        ('<link name="base"/>', '<link name="base"/><link name="base"/>', 'named twice'),
    ],
)
def test_bad_joint(arms, old, new, fault):
    body = '<link name="base"/>' + arms.link('rod', 1.0) + arms.joint('j', 'base', 'rod')
    assert old in body
    with pytest.raises(ModelError) as error:
        arms.load(body.replace(old, new))
    assert fault in one_line(error)


@pytest.mark.parametrize(
    'text',
    [
        '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
        '<robot name="&b;"/>',
        '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]><robot>&x;</robot>',
        '<robot',
        '<html/>',
        '',
    ],
)
def test_hostile_or_broken_xml(arms, text):
    folder = arms.write('')
    (folder / 'robot.urdf').write_text(text)
    with pytest.raises(ModelError) as error:
        load_robot(folder)
    one_line(error)


@pytest.mark.parametrize(
    ('text', 'fault'),
    [
        ('joints: {k: {}}', 'unknown joint'),
        ('joints: {j: {drive: {stifness: 1}}}', 'unknown field'),
        ('joints: {j: {drive: {stiffness: soft}}}', 'not a number'),
        ('joints: {j: {drive: {stiffness: .nan}}}', 'not a finite number'),
        ('joints: {j: {drive: {stiffness: -5.0}}}', 'positive stiffness'),
        ('joints: {j: {drive: {stiffness: 5.0, damping: -60}}}', 'drive: negative damping'),
        ('joints: {j: {tilts: [{stiffness: 0.0}, {}]}}', 'positive stiffness'),
        ('joints: {j: {tilts: [{}]}}', 'tilts are two springs'),
        ('joints: {j: {servo: {stiffness: 5.0}}}', 'needs a drive stiffness'),
        ('joints: [1]', 'not a mapping'),
        ('masses: [{name: m, link: nowhere, mass_kg: 1}]', 'unknown link'),
        ('masses: [{name: m, link: rod}]', 'mass_kg missing'),
        ('masses: {a: 1}', 'not a list'),
        ('limits: {j: {velocity_deg_s: -1}}', 'limits are empty'),
        ('poses_controller_deg: {P: [1, 2]}', 'bad pose'),
        ('coupling: [{axis: j, added: k}]', 'unknown joint'),
        ('gravity_m_s2: [0, 0]', 'wrong length'),
        ('colour: blue', 'unknown field'),
        (
            'beams: [{name: b, link: rod, start_m: [0,0,0], end_m: [0,0,0], bending_n_m2: [1,1]}]',
            'beam needs a length',
        ),
        (
            'beams: [{name: b, link: rod, start_m: [0,0,0], end_m: [0,0,1], bending_n_m2: [1,1], '
            'mass_kg: 99}]',
            'beam heavier',
        ),
        ('base: {springs: [{stiffness: 1}]}', 'wrong length'),
        ('a: &x [1]\nb: *x', 'aliases'),
        ('- 1', 'not a mapping'),
    ],
)
def test_bad_model_file(arms, text, fault):
    with pytest.raises(ModelError) as error:
        model = arms.pendulum(text)
        model.modes([0.0])
    assert fault in one_line(error)


def test_missing_files(tmp_path):
    (tmp_path / 'model.yaml').write_text('{}')
    with pytest.raises(ModelError, match='cannot be read'):
        load_robot(tmp_path)
    with pytest.raises(ModelError):
        load_robot(tmp_path / 'void')


def test_broken_layout(arms):
    folder = arms.write('')
    (folder / 'sensors.yaml').write_text('sensors: []')
    with pytest.raises(LayoutError, match='no sensors'):
        load_layout(folder)


def test_a_sensor_in_millimetres_is_refused_and_named(arms):
    model = arms.pendulum('{}')

    def layout(*place):
        return SensorLayout((Sensor('tip', 'rod', place),), 'sensors.yaml')

    model.check_layout(layout(0.45, 0.05, 0.04))
    with pytest.raises(LayoutError, match=r'sensor tip sits far off its link \(found 454\.5 m'):
        model.check_layout(layout(450.0, 50.0, 40.0))
    with pytest.raises(LayoutError, match='unknown link'):
        model.check_layout(SensorLayout((Sensor('tip', 'nowhere'),)))


def two_links(arms, model_yaml, step='0.6 0 0', mass=3.0):
    body = '<link name="base"/>' + ''.join(
        arms.link(name, mass, '0 0 -0.2', (0.2, 0.2, 0.1)) for name in ('upper', 'lower')
    )
    joints = arms.joint('j', 'base', 'upper'), arms.joint('k', 'upper', 'lower', step)
    return arms.load(body + ''.join(joints), model_yaml)


SOFT = 'joints: {j: {drive: {stiffness: 1e4}}, k: {drive: {stiffness: 1e4}}}'


def test_an_arm_as_usual_has_no_notes(arms, shipped):
    assert model_notes(two_links(arms, SOFT)) == model_notes(shipped[0]) == ()
    assert model_notes(two_links(arms, '{}')) == (), 'rigid as a whole'
    assert two_links(arms, SOFT).robot.reach_m == pytest.approx(0.6)


@pytest.mark.parametrize(
    ('changes', 'told'),
    [
        ({'model_yaml': 'joints: {j: {drive: {stiffness: 1e4}}}'}, 'rigid: k'),
        (
            {'model_yaml': SOFT.replace('{stiffness: 1e4}}, k', '{stiffness: .inf}}, k')},
            'rigid: j',
        ),
        ({'step': '600 0 0'}, 'reach 600 m: are its lengths in metres'),
        ({'mass': 9e9}, 'what j moves weighs 9e+09 kg'),
    ],
)
def test_what_a_model_leaves_out_or_has_in_another_unit_is_noted(arms, changes, told):
    assert told in model_notes(two_links(arms, **({'model_yaml': SOFT} | changes)))[0]


def test_gravity_that_overturns_the_springs_is_an_error(arms):
    model = arms.pendulum('joints: {j: {drive: {stiffness: 5.0}}}')
    with pytest.raises(ModelError, match='stiffness matrix is not positive definite'):
        model.modes([0.0])


def test_changing_a_model_leaves_it_alone():
    model = load_robot('generic_arm_6')
    name = 'joints.a2.drive.spring.stiffness'
    softer = model.with_parameters(
        {name: 0.5 * model.parameters()[name], 'masses.tool.mass_kg': 9}
    )
    assert softer.parameters()[name] == 0.5 * model.parameters()[name]
    assert softer.parameters()['masses.tool.mass_kg'] == 9.0
    assert model.parameters()['masses.tool.mass_kg'] == 6.0
    q = model.pose('home')
    assert softer.modes(q).frequency_hz[0] < model.modes(q).frequency_hz[0]
    assert robot_folder('generic_arm_6').name == 'generic_arm_6'


def test_saved_model_loads_as_the_same(shipped, tmp_path):
    import dataclasses

    from structural_model.description import (
        AbsorberSpec,
        CableSpec,
        CompensatorSpec,
        FoundationSpec,
        HingeSpec,
        KnownEffect,
        KnownNumber,
        RodSpec,
        Spring,
    )
    from structural_model.robot_writer import save_robot

    model, _ = shipped
    first, second = model.joint_names[1:3]
    link = model.link_names[3]
    joints = [dataclasses.replace(item, offset_rad=0.01) for item in model.spec.joints]
    block = FoundationSpec((Spring(1e8, 1e4), *(Spring(),) * 5), 2e3, 0.5, (0.0, 0.0, -0.4), 0.3)
    spec = dataclasses.replace(
        model.spec,
        joints=tuple(joints),
        foundation=block,
        cables=(CableSpec('hose', link, (0.1, 0.0, 0.0), (0.5, 1.0, 3.0), 4e4),),
        effects=(
            KnownEffect('payload', link),
            KnownEffect(
                'backlash',
                second,
                'links',
                'effects',
                (KnownNumber('half_gap', 1e-4, 2e-5, 'rad'),),
            ),
        ),
        hinges=(HingeSpec('h', link, (0.1, 0.0, 0.0), (0.0, 0.0, 1.0), Spring(1e6, 5.0)),),
        absorbers=(AbsorberSpec('a', link, (0.0,) * 3, (1.0, 0.0, 0.0), 4.0, Spring(3e4)),),
        rods=(RodSpec('r', ((first, 1.0), (second, -1.0)), Spring(2e5)),),
        compensators=(CompensatorSpec('c', first, 800.0, 0.1),),
    )
    changed = model.replace(spec)
    save_robot(changed, tmp_path / 'robot', 'with two effects')
    again = load_robot(tmp_path / 'robot')
    assert again.spec == changed.spec
    assert again.dof_names == changed.dof_names
    for part in ('controller_low', 'position_high', 'velocity', 'jerk', 'effort'):
        np.testing.assert_allclose(getattr(again.limits, part), getattr(changed.limits, part))
    q = model.pose(next(iter(model.poses_controller_rad)))
    np.testing.assert_allclose(again.modes(q).frequency_hz, changed.modes(q).frequency_hz)


def test_an_arm_of_unknown_size_is_not_bounded(arms):
    model = arms.pendulum('joints: {j: {drive: {stiffness: 5000.0}}}')
    assert model.geometry.clearance([0.0]) is None
    for ask in (
        lambda: model.geometry.fastest_point([[0.0]], [[1.0]]),
        lambda: model.geometry.extent([[0.0]]),
    ):
        with pytest.raises(ModelError, match='no moving link has a simple shape'):
            ask()


def test_meshes_are_passed_over_and_sizes_checked(arms):
    mesh = '<visual><geometry><mesh filename="package://x/y.stl"/></geometry></visual>'
    ball = '<collision><geometry><sphere radius="{}"/></geometry></collision>'
    rod = arms.link('rod', 1.0, '0 0 1').replace('</link>', mesh + ball + '</link>')
    body = '<link name="base"/>' + rod + arms.joint('j', 'base', 'rod')
    model = arms.load(body.replace('{}', '0.1'), 'joints: {j: {drive: {stiffness: 5000.0}}}')
    assert model.geometry.fastest_point([[0.0]], [[2.0]]).speed_m_s[0] == pytest.approx(0.2)
    with pytest.raises(ModelError, match='size is not positive'):
        arms.load(body.replace('{}', '-1'))
