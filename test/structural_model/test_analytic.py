"""Arms small enough for a closed form."""

import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from modal_core.errors import ModelError

GRAVITY = 9.81
SPRING = 'joints: {j: {drive: {stiffness: 5000.0, damping: 12.0}}}'


@pytest.mark.parametrize('angle', [0.0, 0.7, 2.5])
def test_pendulum_on_a_spring_at_any_posture(arms, angle):
    model = arms.pendulum(SPRING)
    inertia = 0.2 + 3.0 * 0.8**2
    stiffness = 5000.0 - 3.0 * GRAVITY * 0.8 * np.cos(angle)  # standing up at q = 0
    modes = model.modes([angle])
    omega = np.sqrt(stiffness / inertia)
    assert modes.frequency_hz[0] == pytest.approx(omega / (2 * np.pi), rel=1e-10)
    assert modes.damping_ratio[0] == pytest.approx(12.0 / (2 * inertia * omega), rel=1e-10)
    pole = model.damped_modes([angle]).poles_1_s[0]
    assert pole == pytest.approx(
        np.roots([inertia, 12.0, stiffness])[0].conjugate(), rel=1e-9
    ) or pole == pytest.approx(np.roots([inertia, 12.0, stiffness])[0], rel=1e-9)


def test_static_deflection_balances_gravity(arms):
    model = arms.pendulum(SPRING)
    deflection = model.static_deflection([1.0])[0]
    assert 5000.0 * deflection == pytest.approx(
        3.0 * GRAVITY * 0.8 * np.sin(1.0 + deflection), rel=1e-12
    )


def test_what_is_held_by_nothing_hangs_nowhere(arms):
    """A spring that gravity makes up for exactly is no arm, and said so as any other."""
    spring = 'joints: {j: {drive: {stiffness: 4.0}}}'
    model = arms.pendulum(f'gravity_m_s2: [0.0, 0.0, -8.0]\n{spring}', mass=1.0, arm=0.5)
    with pytest.raises(ModelError, match='no static equilibrium'):
        model.static_deflection([0.0])


def test_bearing_tilts_move_across_the_axis(arms):
    model = arms.pendulum(
        'gravity_m_s2: [0.0, 0.0, 0.0]\n'
        'joints: {j: {tilts: [{stiffness: 800.0}, {stiffness: 7000.0}]}}'
    )
    # Axis y: first tilt about z (spins the rod), second about x (swings it sideways).
    assert model.dof_names == ('j/tilt_1', 'j/tilt_2')
    expected = np.sqrt([7000.0 / (0.2 + 3.0 * 0.8**2), 800.0 / 0.01]) / (2 * np.pi)
    assert model.modes([0.0]).frequency_hz == pytest.approx(sorted(expected), rel=1e-10)


def test_prismatic_joint(arms):
    model = arms.pendulum(
        'joints: {j: {drive: {stiffness: 1.0e+5}}}', kind='prismatic', axis='1 0 0'
    )
    assert model.modes([0.2]).frequency_hz[0] == pytest.approx(
        np.sqrt(1e5 / 3.0) / (2 * np.pi), rel=1e-10
    )


def test_two_link_arm_against_its_textbook_mass_matrix(arms):
    l1, c1, c2, m1, m2, i1, i2 = 0.9, 0.5, 0.4, 6.0, 4.0, 0.5, 0.3
    body = (
        '<link name="base"/>'
        + arms.link('one', m1, f'{c1} 0 0', (i1, i1, i1))
        + arms.link('two', m2, f'{c2} 0 0', (i2, i2, i2))
        + arms.joint('a', 'base', 'one', axis='0 0 1')
        + arms.joint('b', 'one', 'two', xyz=f'{l1} 0 0', axis='0 0 1')
    )
    model = arms.load(
        body, 'joints: {a: {drive: {stiffness: 3000.0}}, b: {drive: {stiffness: 900.0}}}'
    )
    q = np.array([0.3, 1.1])
    cross = m2 * l1 * c2 * np.cos(q[1])
    m22 = i2 + m2 * c2**2
    M = np.array(
        [[i1 + m1 * c1**2 + m22 + m2 * l1**2 + 2 * cross, m22 + cross], [m22 + cross, m22]]
    )
    matrices = model.matrices(q)
    np.testing.assert_allclose(matrices.M, M, rtol=1e-12)
    np.testing.assert_allclose(matrices.K, np.diag([3000.0, 900.0]), atol=1e-9)
    np.testing.assert_allclose(model.input_matrix(q), -M, rtol=1e-12)


def test_coupled_drive_acts_on_the_sum_of_both_twists(arms):
    body = (
        '<link name="base"/>'
        + arms.link('one', 6.0, '0.5 0 0')
        + arms.link('two', 4.0, '0.4 0 0')
        + arms.joint('a', 'base', 'one', axis='0 0 1')
        + arms.joint('b', 'one', 'two', xyz='0.9 0 0', axis='0 0 1')
    )
    text = (
        'coupling: [{axis: b, added: a}]\n'
        'joints: {a: {drive: {stiffness: 300.0}}, b: {drive: {stiffness: 90.0}}}\n'
        'rods: [{name: rod, weights: {a: 1, b: -1}, spring: {stiffness: 7.0}}]'
    )
    K = arms.load(body, text).matrices([0.0, 0.5]).K
    expected = [[300.0 + 90.0 + 7.0, 90.0 - 7.0], [90.0 - 7.0, 90.0 + 7.0]]
    np.testing.assert_allclose(K, expected, atol=1e-9)


def beam_arm(arms, mass, elements, tip_mass=0.0, root_mass=0.0):
    """A slender rod along x, clamped by a rigid joint, as a beam of EI = 2000 and 3000 N m²."""
    length = 1.3
    inertia = mass * length**2 / 12
    body = (
        '<link name="base"/>'
        + arms.link('rod', mass, f'{length / 2} 0 0', (1e-12, inertia, inertia))
        + '<link name="tip"/>'
        + arms.joint('j', 'base', 'rod')
        + arms.joint('end', 'rod', 'tip', xyz=f'{length} 0 0', kind='fixed')
    )
    masses = f'masses: [{{name: tip, link: tip, mass_kg: {tip_mass}}}]\n' if tip_mass else ''
    return arms.load(
        body,
        f'gravity_m_s2: [0.0, 0.0, 0.0]\n{masses}'
        f'beams: [{{name: rod, link: rod, start_m: [0.0, 0.0, 0.0], end_m: [{length}, 0.0, 0.0], '
        f'bending_n_m2: [2000.0, 3000.0], mass_kg: {mass}, elements: {elements}}}]',
    ), length


def test_cantilever_beam_converges_to_its_textbook_roots(arms):
    """Lumping errs with the square of the segment length, so two meshes extrapolate."""
    roots = np.array([1.87510407, 4.69409113])
    coarse, length = beam_arm(arms, 8.0, 8)
    first = coarse.modes([0.0]).frequency_hz[:4]
    second = beam_arm(arms, 8.0, 16)[0].modes([0.0]).frequency_hz[:4]
    expected = (
        np.sort(np.outer(np.sqrt([2000.0, 3000.0]), roots**2).ravel())
        / np.sqrt(8.0 / length * length**4)
        / (2 * np.pi)
    )
    assert first == pytest.approx(expected, rel=1e-2)
    assert (expected - first) / (expected - second) == pytest.approx(4.0, rel=0.05)
    assert (4.0 * second - first) / 3.0 == pytest.approx(expected, rel=1e-4)


def test_beam_twists_and_stretches(arms):
    """A massless beam with a heavy tip: GJ/L on its moment of inertia, EA/L on its mass."""
    body = (
        '<link name="base"/>'
        + arms.link('rod', 1e-3, '0.5 0 0', (1e-6, 1e-3 / 12, 1e-3 / 12))
        + arms.joint('j', 'base', 'rod')
    )
    text = (
        'gravity_m_s2: [0.0, 0.0, 0.0]\n'
        'masses: [{name: tip, link: rod, mass_kg: 5.0, position_m: [1.0, 0.0, 0.0], '
        'gyration_m: [0.2, 0.2, 0.2]}]\n'
        'beams: [{name: rod, link: rod, start_m: [0.0, 0.0, 0.0], end_m: [1.0, 0.0, 0.0], '
        'bending_n_m2: [.inf, .inf], torsion_n_m2: 60.0, axial_n: 7.0e+4, mass_kg: 0.0009, '
        'gyration_m: 0.01, elements: 3}]'
    )
    found = arms.load(body, text).modes([0.0]).frequency_hz
    expected = np.sqrt([60.0 / (5.0 * 0.2**2), 7e4 / 5.0]) / (2 * np.pi)
    assert found[:2] == pytest.approx(expected, rel=1e-3)


def test_cantilever_beam_with_a_heavy_tip(arms):
    model, length = beam_arm(arms, 1e-3, 2, tip_mass=20.0)
    expected = np.sqrt(3 * np.array([2000.0, 3000.0]) / (20.0 * length**3)) / (2 * np.pi)
    assert model.modes([0.0]).frequency_hz[:2] == pytest.approx(expected, rel=1e-3)


def test_beam_keeps_the_inertia_of_its_link(arms):
    model, _ = beam_arm(arms, 8.0, 4)
    rigid = arms.load(
        '<link name="base"/>'
        + arms.link('rod', 8.0, '0.65 0 0', (1e-12, 8 * 1.3**2 / 12, 8 * 1.3**2 / 12))
        + arms.joint('j', 'base', 'rod')
    )
    zero = np.zeros(1)
    assert model.torque([0.4], zero, [1.0]) == pytest.approx(
        rigid.replace(type(rigid.spec)(rigid.spec.joints, gravity_m_s2=(0.0, 0.0, 0.0))).torque(
            [0.4], zero, [1.0]
        ),
        rel=1e-9,
    )


def test_hinge_in_a_link_is_a_spring_in_series(arms):
    """Both springs on one axis with the whole inertia outboard add their compliances."""
    model = arms.pendulum(
        'gravity_m_s2: [0.0, 0.0, 0.0]\n'
        'joints: {j: {drive: {stiffness: 5000.0}}}\n'
        'hinges: [{name: h, link: rod, position_m: [0.0, 0.0, 0.0], axis: [0.0, 1.0, 0.0], '
        'spring: {stiffness: 2000.0}, outboard_share: 0.9999999}]'
    )
    series = 1.0 / (1.0 / 5000.0 + 1.0 / 2000.0)
    assert model.modes([0.0]).frequency_hz[0] == pytest.approx(
        np.sqrt(series / (0.2 + 3.0 * 0.8**2)) / (2 * np.pi), rel=1e-5
    )


def test_six_degree_base(arms):
    springs = ', '.join(f'{{stiffness: {k}}}' for k in (1e5, 2e5, 3e5, 4e3, 5e3, 6e3))
    body = (
        arms.link('base', 10.0, '0 0 0', (0.4, 0.5, 0.6))
        + arms.link('rod', 1e-6)
        + arms.joint('j', 'base', 'rod')
    )
    model = arms.load(body, f'base: {{springs: [{springs}]}}')
    assert model.dof_names == tuple(f'base/{n}' for n in ('tx', 'ty', 'tz', 'rx', 'ry', 'rz'))
    expected = np.sqrt([1e4, 2e4, 3e4, 1e4, 1e4, 1e4]) / (2 * np.pi)
    assert model.modes([0.0]).frequency_hz == pytest.approx(sorted(expected), rel=1e-3)


def test_soft_servo_against_the_two_mass_oscillator(arms):
    model = arms.pendulum(
        'gravity_m_s2: [0.0, 0.0, 0.0]\n'
        'joints: {j: {drive: {stiffness: 5000.0}, servo: {stiffness: 4000.0, damping: 30.0}, '
        'gear_ratio: 100, rotor_inertia_kg_m2: 0.0002}}'
    )
    inertia, rotor = 0.2 + 3.0 * 0.8**2, 2.0
    K = np.array([[5000.0, -5000.0], [-5000.0, 9000.0]])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.diag([1 / inertia, 1 / rotor]) @ K)))
    assert model.dof_names == ('j/drive', 'j/motor')
    assert model.modes([0.0]).frequency_hz == pytest.approx(expected / (2 * np.pi), rel=1e-10)
    np.testing.assert_allclose(model.matrices([0.0]).C, np.diag([0.0, 30.0]), atol=1e-12)


def test_absorber_splits_the_mode(arms):
    model = arms.pendulum(
        'gravity_m_s2: [0.0, 0.0, 0.0]\n'
        'joints: {j: {drive: {stiffness: 5000.0}}}\n'
        'absorbers: [{name: hose, link: rod, position_m: [0.0, 0.0, 1.0], axis: [1.0, 0.0, 0.0], '
        'mass_kg: 0.5, spring: {stiffness: 1100.0}}]'
    )
    inertia = 0.2 + 3.0 * 0.8**2
    M = np.array([[inertia + 0.5, 0.5], [0.5, 0.5]])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, np.diag([5000.0, 1100.0])))))
    assert model.modes([0.0]).frequency_hz == pytest.approx(expected / (2 * np.pi), rel=1e-9)


def test_gravity_compensator_takes_the_load_and_adds_stiffness(arms):
    plain = arms.pendulum(SPRING)
    balanced = arms.pendulum(
        SPRING + f'\ncompensators: [{{name: c, joint: j, strength_nm: {3.0 * GRAVITY * 0.8}}}]'
    )
    zero = np.zeros(1)
    assert abs(plain.torque([0.6], zero, zero)[0]) > 10.0
    assert balanced.torque([0.6], zero, zero)[0] == pytest.approx(0.0, abs=1e-9)
    assert balanced.matrices([0.6]).K[0, 0] == pytest.approx(5000.0, rel=1e-12)
    assert balanced.static_deflection([0.6])[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('strength', [0.0, 200.0, 1500.0])
def test_sag_is_the_static_deflection_however_far_the_arm_hangs(arms, strength):
    model = arms.pendulum(
        SPRING
        + f'\ncompensators: [{{name: c, joint: j, strength_nm: {strength}, phase_rad: 1.2}}]'
    )
    exact = model.static_deflection([0.6])[0]
    assert abs(exact) > (0.1 if strength > 1000.0 else 1e-4)
    assert model.dynamics.sag([0.6])[0] == pytest.approx(exact, abs=1e-5)


def test_payload_equals_the_same_mass_in_the_urdf(arms):
    heavy = arms.pendulum(SPRING, mass=3.0, arm=0.8, inertia=0.2)
    light = arms.pendulum(
        SPRING + '\nmasses: [{name: m, link: rod, mass_kg: 1.0, position_m: [0.0, 0.0, 0.8], '
        'gyration_m: [0.1, 0.2, 0.3]}]',
        mass=2.0,
        inertia=0.16,
    )
    np.testing.assert_allclose(light.matrices([0.4]).M, heavy.matrices([0.4]).M, rtol=1e-12)
    np.testing.assert_allclose(light.matrices([0.4]).K, heavy.matrices([0.4]).K, rtol=1e-12)


@pytest.mark.parametrize('angle', [0.0, 0.7])
def test_sensors_on_an_arm_of_one_joint(arms, angle):
    """What rides at height h on a rod about y moves by h along the rod's x per radian."""
    model = arms.pendulum(SPRING)
    channels = SensorLayout((Sensor('s', 'rod', (0.0, 0.0, 0.5)),)).channels
    np.testing.assert_allclose(
        model.sensor_jacobian([angle], channels), [[0.5], [0.0], [0.0]], atol=1e-12
    )
    # An accelerometer at rest reads -g in its own axes: (-sin, 0, cos) times 9.81.
    np.testing.assert_allclose(
        model.gravity_jacobian([angle], channels),
        GRAVITY * np.array([[-np.cos(angle)], [0.0], [-np.sin(angle)]]),
        atol=1e-12,
    )
    shape = model.modes([angle], channels).channel_shapes
    assert shape.shape == (3, 1) and abs(shape[1, 0]) < 1e-12


def test_a_cable_to_an_arm_of_one_joint(arms):
    """It shortens by the lever about the joint, here its whole length."""
    cable = 'cables: [{name: c, link: rod, position_m: [0, 0, 0.5], anchor_m: [9, 0, 0.5], '
    model = arms.pendulum(f'{SPRING}\n{cable}stiffness_n_m: 700.0}}]')
    without = 5000.0 - 3.0 * GRAVITY * 0.8
    assert model.matrices([0.0]).K[0, 0] == pytest.approx(without + 700.0 * 0.5**2, rel=1e-10)
