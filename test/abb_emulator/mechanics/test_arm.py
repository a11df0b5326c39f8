"""The plant against known truth: equilibrium, poles, forced response, and a free integration."""

import numpy as np
import pytest

from abb_emulator.mechanics.arm import Arm
from abb_emulator.mechanics.gear_settings import GearSettings
from modal_core.channel import Channel
from modal_core.units import ANGULAR_VELOCITY
from structural_model import load_layout, load_robot
from structural_model.equations import damped_modes
from test.support import reference_arm

RATE_HZ = 2048.0
STEP_S = 1.0 / RATE_HZ


@pytest.fixture(scope='module')
def model():
    return load_robot('irb6660_205_190')


@pytest.fixture(scope='module')
def channels():
    return load_layout('irb6660_205_190', 'sensors').channels


@pytest.fixture(scope='module')
def reference():
    return reference_arm


def still(pose, n):
    return np.tile(pose, (n, 1)), np.zeros((n, 6)), np.zeros((n, 6))


def run(arm, motion, n, block=64):
    """Return readings and deflections of an arm that follows a motion, in blocks."""
    rows = np.array([motion((k + 1) * STEP_S) for k in range(n)])
    parts = [arm.advance(*rows[i : i + block].transpose(1, 0, 2)) for i in range(0, n, block)]
    return (
        np.concatenate([part.readings for part in parts]),
        np.concatenate([part.deflection for part in parts]),
    )


def equilibrium(model, pose):
    """Return M, C, K of small motion about the arm as it hangs in its own weight."""
    return model.matrices(pose, model.static_deflection(pose))


def wide(pose):
    """All axes through 20 to 60 degrees in 0.9 s, no jump in any derivative up to the third."""
    way, length_s = np.radians([40.0, -25.0, 20.0, 40.0, 40.0, 60.0]), 0.9

    def motion(time_s):
        u = min(max(time_s / length_s, 0.0), 1.0)
        part = u**4 * (35 - 84 * u + 70 * u * u - 20 * u**3)
        rate = 140 * u**3 * (1 - u) ** 3 / length_s
        rise = 420 * (u * (1 - u)) ** 2 * (1 - 2 * u) / length_s**2
        return pose + part * way, rate * way, rise * way

    return motion


def shaking(pose, peak_deg_s2, seed=3):
    """Return one sine of 8 to 30 Hz per axis, faded in over 0.1 s."""
    random = np.random.default_rng(seed)
    omega, phase = 2 * np.pi * random.uniform(8, 30, 6), random.uniform(0, 6, 6)
    size = np.radians(peak_deg_s2) / omega**2

    def motion(time_s):
        u = min(time_s / 0.1, 1.0)
        c = u**3 * (10 + u * (6 * u - 15))
        dc, ddc = 300 * (u * (1 - u)) ** 2, 6000 * u * (1 - u) * (1 - 2 * u)
        sine = size * (np.sin(omega * time_s + phase) - np.sin(phase))
        rate = size * omega * np.cos(omega * time_s + phase)
        rise = -size * omega**2 * np.sin(omega * time_s + phase)
        return pose + c * sine, c * rate + dc * sine, c * rise + 2 * dc * rate + ddc * sine

    return motion


def error_of(found, expected):
    """Return the rms error over the rms of what moves."""
    moved = expected - expected.mean(axis=0)
    return float(np.sqrt(np.mean((found - expected) ** 2) / np.mean(moved**2)))


@pytest.mark.parametrize('robot', ['irb6660_205_190', 'generic_arm_6'])
def test_at_rest_it_reads_gravity_and_nothing_moves(robot):
    model, channels = load_robot(robot), load_layout(robot, 'sensors').channels
    pose = model.pose(next(iter(model.poses_controller_rad)))
    arm = Arm(model, channels, pose, STEP_S)
    found = arm.advance(*still(pose, 512))
    assert np.ptp(found.readings, axis=0).max() < 1e-7
    np.testing.assert_allclose(found.deflection[-1], model.static_deflection(pose), atol=1e-11)
    np.testing.assert_allclose(found.readings[-1], arm.at_rest(), atol=1e-7)
    magnitude = np.linalg.norm(found.readings[0].reshape(-1, 3), axis=1)
    np.testing.assert_allclose(magnitude, 9.81, rtol=1e-6)


def test_free_decay_has_the_true_poles(model, channels):
    pose = model.pose('P3')
    truth = damped_modes(equilibrium(model, pose), np.zeros((0, model.n_dof)))
    n = 400
    for index in range(4):
        pole, shape = truth.poles_1_s[index], truth.shapes[:, index]
        # From a free decay that has been going on: the foreseen x'' must be there as well.
        scale = 1e-6 / np.abs(shape).max()
        arm = Arm(model, channels, pose, STEP_S)
        rest = arm.state
        arm.let_go(
            rest + scale * np.concatenate([shape.real, (pole * shape).real]),
            scale * (pole**2 * shape).real,
            scale * (pole**2 * np.exp(-pole * STEP_S) * shape).real,
        )
        arm.advance(*still(pose, n))
        factor = np.exp(pole * n * STEP_S)
        expected = scale * np.concatenate([(factor * shape).real, (pole * factor * shape).real])
        np.testing.assert_allclose(
            arm.state - rest, expected, atol=2e-3 * np.abs(expected).max(), err_msg=f'{index}'
        )


def test_forced_response_is_that_of_the_accelerance(model, channels):
    """A steady sine of one motor gives the linear response about the equilibrium."""
    pose, hz, axis = model.pose('P1'), 15.0, 1
    omega, amplitude, unit = 2 * np.pi * hz, 1e-5, np.eye(6)[axis]

    def motion(time_s):
        angle = amplitude * np.sin(omega * time_s)
        rate = amplitude * omega * np.cos(omega * time_s)
        return pose + angle * unit, rate * unit, -(omega**2) * angle * unit

    n = int(4 * RATE_HZ)
    readings = run(Arm(model, channels, pose, STEP_S), motion, n, 256)[0][n // 2 :]
    tail = (np.arange(n // 2, n) + 1) * STEP_S
    window = np.hanning(len(tail))
    found = (
        2 * (window * np.exp(-1j * omega * tail)) @ (readings - readings.mean(0)) / window.sum()
    )
    matrices = equilibrium(model, pose)
    dynamic = matrices.K - omega**2 * matrices.M + 1j * omega * matrices.C
    drive = -1j * amplitude * unit  # sin as the real part of -j exp
    load = model.input_matrix(pose) @ (-(omega**2) * drive) - model.gravity_coupling(pose) @ drive
    flexible = np.linalg.solve(dynamic, load)
    expected = model.sensor_jacobian(pose, channels) @ (-(omega**2) * flexible)
    expected += model.rigid_jacobian(pose, channels) @ (-(omega**2) * drive)
    # Input and sensors are taken at the unbent pose, the tilt of the sensors is left out.
    np.testing.assert_allclose(found, expected, atol=1e-2 * np.abs(expected).max())


@pytest.mark.parametrize('kind', ['wide move', 'shaking'])
def test_the_whole_arm_agrees_with_a_free_integration(
    model, channels, reference, kind, record_property
):
    """Of the flexible part alone: what a sensor reads less what it would on a rigid arm."""
    pose, n = model.pose('P1'), 512
    motion = wide(pose) if kind == 'wide move' else shaking(pose, 800.0)
    arm = Arm(model, channels, pose, STEP_S)
    deflection = run(arm, motion, n)[1]
    x = reference.ReferenceArm(model, motion).run(
        model.static_deflection(pose), n, STEP_S, 2
    )[0]  # fmt: skip
    found = error_of(deflection, x)
    record_property('deflection_error', found)
    print(f'{kind}: deflection error {found:.2e}')
    assert found < 1e-3


def test_sensors_see_the_motion_of_the_bent_arm(model, reference):
    """Differences of place and rotation, by kinematics of the test's own, at the plant's x."""
    pose, n = model.pose('P1'), 320
    directions = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
    channels = [
        Channel(f'{link}.{unit}{axis}', link, direction, (0.1, -0.05, 0.2), unit)
        for link in ('link_1', 'link_4', 'flange')
        for unit in ('m/s^2', ANGULAR_VELOCITY)
        for axis, direction in enumerate(directions)
    ]
    motion = wide(pose)
    arm = Arm(model, channels, pose, STEP_S)
    readings, deflection = run(arm, motion, n)
    flexible, drives = model.assembly.flexible, model.assembly.drives
    gravity = np.array(model.spec.gravity_m_s2)
    for number, link in enumerate(('link_1', 'link_4', 'flange')):
        attached = model.assembly.attach(link, np.array((0.1, -0.05, 0.2)))
        turns, places = [], []
        for k in range(n):
            full = np.zeros(model.assembly.model.nv)
            full[drives] = motion((k + 1) * STEP_S)[0]
            full[flexible] += deflection[k]
            rotation, place = reference.place_of_sensor(model, *attached, full)
            turns.append(rotation)
            places.append(place)
        turns, places = np.array(turns), np.array(places)
        acceleration = (places[2:] - 2 * places[1:-1] + places[:-2]) * RATE_HZ**2
        force = np.einsum('nji,nj->ni', turns[1:-1], acceleration - gravity)
        change = np.einsum('nji,njk->nik', turns[:-2], turns[2:])  # two steps
        spin = np.stack([change[:, 2, 1], change[:, 0, 2], change[:, 1, 0]], axis=1)
        spin -= np.stack([change[:, 1, 2], change[:, 2, 0], change[:, 0, 1]], axis=1)
        spin *= RATE_HZ / 4.0
        here = readings[1:-1, 6 * number : 6 * number + 6]
        np.testing.assert_allclose(here[:, :3], force, atol=2e-3 * np.abs(force).max())
        np.testing.assert_allclose(here[:, 3:], spin, atol=1e-3 * np.abs(spin).max())
        assert np.abs(spin).max() > 0.3


GEARS = {
    'hardening': (GearSettings(hardening_1_rad2=(1e6,) * 6), 2, 2e-3),
    'play': (GearSettings(backlash_rad=(5e-5,) * 6), 4, 5e-3),
    'friction': (
        GearSettings(friction_nm=(50, 50, 50, 10, 10, 10), friction_speed_rad_s=5e-3), 10, 1e-2,
    ),
}  # fmt: skip


@pytest.mark.parametrize('kind', GEARS)
def test_gears_agree_with_a_free_integration(model, reference, kind, record_property):
    gears, substeps, largest = GEARS[kind]
    pose, n = model.pose('P1'), 192
    motion = shaking(pose, 80.0)
    arm = Arm(model, (), pose, STEP_S, gears)
    start = arm.state[: model.n_dof]
    found = run(arm, motion, n)[1]
    expected = reference.ReferenceArm(model, motion, gears).run(start, n, STEP_S, substeps)[0]
    linear = run(Arm(model, (), pose, STEP_S), motion, n)[1]
    plain = error_of(linear - linear[0] + expected[0], expected)
    error = error_of(found, expected)
    record_property(f'{kind}_error', error)
    print(f'{kind}: error {error:.1e}, without it {plain:.2f}')
    assert plain > 0.1
    assert error < largest


def test_a_nonlinear_arm_rests_where_its_torques_balance(model):
    pose, alpha = model.pose('P1'), 1e6
    gears = GearSettings(hardening_1_rad2=(alpha,) * 6, backlash_rad=(2e-5,) * 6)
    arm = Arm(model, (), pose, STEP_S, gears)
    found = arm.advance(*still(pose, 256)).deflection
    # An axis without weight floats in its play: a thousandth of it.
    assert np.ptp(found, axis=0).max() < 2e-8
    plain = Arm(model, (), pose, STEP_S).state[: model.n_dof]
    spring = np.array([joint.drive.spring.stiffness for joint in model.spec.joints])
    twists = [
        np.array([x[model.dof_names.index(f'{name}/drive')] for name in model.joint_names])
        @ model.axes.matrix.T
        for x in (plain, found[-1])
    ]
    wound = np.sign(twists[1]) * np.maximum(np.abs(twists[1]) - 2e-5, 0.0)
    # The same weight hangs on the same springs, but for a slightly other place of it.
    weight, held = spring * twists[0], spring * (wound + alpha * wound**3)
    np.testing.assert_allclose(held, weight, atol=2e-3 * np.abs(weight).max())


def test_a_slipping_spring_is_slack_at_rest(model):
    pose = model.pose('P1')
    arm = Arm(model, (), pose, STEP_S, GearSettings(slip_share=(0.4,) * 6))
    found = arm.advance(*still(pose, 256)).deflection
    assert np.ptp(found, axis=0).max() < 1e-10
    np.testing.assert_allclose(found[-1], model.static_deflection(pose), atol=1e-10)


def test_friction_takes_energy_out(model, channels):
    pose = model.pose('P1')
    rub = GearSettings(friction_nm=(50.0,) * 6)
    ends = []
    for gears in (None, rub):
        arm = Arm(model, channels, pose, STEP_S, gears)
        kick = np.zeros((64, 6))
        kick[:, 1] = 2.0
        arm.advance(np.tile(pose, (64, 1)), np.zeros((64, 6)), kick)
        ends.append(arm.advance(*still(pose, 1024)).readings[-256:].std(axis=0).max())
    assert ends[1] < 0.7 * ends[0]
