"""Properties of the matrices and responses, and independent simulations of the same arm."""

from concurrent.futures import ThreadPoolExecutor
import dataclasses
from itertools import pairwise
import pickle

import numpy as np
import pinocchio as pin
import pytest

from modal_core.channel import Channel
from modal_core.errors import ModelError
from structural_model import load_robot
from structural_model.description import (
    AbsorberSpec,
    BaseSpec,
    CableSpec,
    CompensatorSpec,
    Drive,
    FoundationSpec,
    HingeSpec,
    JointSpec,
    MassSpec,
    MaterialDamping,
    RodSpec,
    Spring,
)
from structural_model.equations import simulate

SEED = 20


def test_mass_and_stiffness_are_symmetric_positive_definite(shipped, poses):
    model, _ = shipped
    for q in poses(model, 30, SEED):
        matrices = model.matrices(q)
        for matrix in (matrices.M, matrices.K, matrices.C):
            np.testing.assert_allclose(matrix, matrix.T, atol=1e-9 * np.abs(matrix).max())
        assert np.linalg.eigvalsh(matrices.M)[0] > 0.0, (SEED, q)
        assert np.linalg.eigvalsh(matrices.K)[0] > 0.0, (SEED, q)
        assert np.linalg.eigvalsh(matrices.C)[0] > -1e-9, (SEED, q)


def test_modes_solve_the_eigenproblem_and_normalise_the_mass(shipped, poses):
    model, layout = shipped
    for q in poses(model, 5, SEED + 1):
        matrices, modes = model.matrices(q), model.modes(q, layout.channels)
        omega2 = (2 * np.pi * modes.frequency_hz) ** 2
        residual = matrices.K @ modes.shapes - matrices.M @ modes.shapes * omega2
        assert np.abs(residual).max() < 1e-7 * np.abs(matrices.K @ modes.shapes).max()
        np.testing.assert_allclose(
            modes.shapes.T @ matrices.M @ modes.shapes, np.eye(model.n_dof), atol=1e-9
        )
        np.testing.assert_allclose(
            modes.channel_shapes, model.sensor_jacobian(q, layout.channels) @ modes.shapes
        )


def test_damped_modes_solve_the_quadratic_problem(shipped, poses):
    """With one damper much larger than the rest, damping is far from proportional."""
    model, _ = shipped
    joint = model.joint_names[1]
    odd = model.with_parameters({f'joints.{joint}.drive.spring.damping': 2e4})
    q = poses(model, 1, SEED + 2)[0]
    m, modes = odd.matrices(q), odd.damped_modes(q)
    for pole, shape in zip(modes.poles_1_s, modes.shapes.T, strict=True):
        residual = (pole**2 * m.M + pole * m.C + m.K) @ shape
        assert np.abs(residual).max() < 1e-6 * np.abs(m.K @ shape).max()


def test_damped_modes_with_proportional_damping_keep_the_undamped_ones(shipped, poses):
    model, _ = shipped
    spec = dataclasses.replace(
        model.spec,
        joints=tuple(
            JointSpec(
                joint.name,
                Drive(Spring(joint.drive.spring.stiffness)),
                (Spring(joint.tilts[0].stiffness), Spring(joint.tilts[1].stiffness)),
            )
            for joint in model.spec.joints
        ),
        base=BaseSpec(),
        damping=MaterialDamping(1.5, 2e-4),
        gravity_m_s2=(0.0, 0.0, 0.0),
    )
    plain = model.replace(spec)
    q = poses(model, 1, SEED + 6)[0]
    damped, undamped = plain.damped_modes(q), plain.modes(q)
    omega = 2 * np.pi * undamped.frequency_hz
    np.testing.assert_allclose(damped.frequency_hz, undamped.frequency_hz, rtol=1e-7)
    np.testing.assert_allclose(damped.damping_ratio, undamped.damping_ratio, rtol=1e-6)
    np.testing.assert_allclose(undamped.damping_ratio, 0.75 / omega + 1e-4 * omega, rtol=1e-9)


@pytest.mark.parametrize('kind', ['receptance', 'mobility', 'accelerance'])
def test_frf_is_reciprocal_and_equals_the_modal_sum(shipped, poses, kind):
    model, layout = shipped
    q = poses(model, 1, SEED + 3)[0]
    channels = layout.channels[6::5]
    frequency = np.linspace(3.0, 90.0, 60)
    H = model.frf(q, channels, channels, frequency, kind)
    np.testing.assert_allclose(H, H.transpose(0, 2, 1), atol=1e-10 * np.abs(H).max())
    modes = model.damped_modes(q, channels)
    s = 2j * np.pi * frequency[:, None]
    factor = s ** {'receptance': 0, 'mobility': 1, 'accelerance': 2}[kind]
    residue = np.einsum('im,jm->ijm', modes.channel_shapes, modes.channel_shapes)
    total = np.einsum('ijm,fm->fij', residue, 1 / (s - modes.poles_1_s)) + np.einsum(
        'ijm,fm->fij', residue.conj(), 1 / (s - modes.poles_1_s.conj())
    )
    np.testing.assert_allclose(factor[:, :, None] * total, H, atol=1e-8 * np.abs(H).max())


def test_time_response_agrees_with_the_frequency_response(shipped, poses):
    """A force burst that has died out: its output spectrum is H times its input spectrum."""
    model, layout = shipped
    q = poses(model, 1, SEED + 4)[0]
    outputs, force = layout.channels[9::7], layout.channels[-2:-1]
    rate, count = 4000.0, 1 << 16
    time = np.arange(count) / rate
    pulse = np.where(time < 0.05, np.sin(np.pi * time / 0.05) ** 2, 0.0)
    system = model.state_space(q, outputs, force)
    inputs = np.zeros((count, model.n_joints + 1))
    inputs[:, -1] = pulse
    response = simulate(system, inputs, rate).output
    assert np.abs(response[-100:]).max() < 1e-4 * np.abs(response).max()
    frequency = np.fft.rfftfreq(count, 1 / rate)
    band = (frequency > 4.0) & (frequency < 35.0)
    found = np.fft.rfft(response, axis=0)[band] / np.fft.rfft(pulse)[band, None]
    # The state space reads gravity through tilt; take it out of the comparison.
    expected = model.frf(q, force, outputs, frequency[band])[:, :, 0]
    tilt = model.gravity_jacobian(q, outputs)
    omega = 2 * np.pi * frequency[band]
    m = model.matrices(q)
    dynamic = m.K - omega[:, None, None] ** 2 * m.M + 1j * omega[:, None, None] * m.C
    push = model.sensor_jacobian(q, force).T
    expected = (
        expected
        + (tilt @ np.linalg.solve(dynamic, np.broadcast_to(push, (len(omega), *push.shape))))[
            :, :, 0
        ]
    )
    np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(expected).max())


def nonlinear_motion(model, q, channels, acceleration, rate):
    """Integrate the full nonlinear flexible arm (own RK4, pinocchio's rigid-body functions only).

    The drives prescribe acceleration of the motor side; deflections follow
    M_ff x'' = -(M_fr q'' + h_f) - K x - C x'; accelerometers from classical frame accelerations.
    """
    assembly = model.assembly
    pm, data = assembly.model, assembly.model.createData()
    flex, drives = assembly.flexible, assembly.drives
    frames = []
    for channel in channels:
        joint, placement = assembly.attach(channel.frame_id, np.array(channel.position_m))
        name = f'sensor {len(frames)}'
        frames.append(pm.addFrame(pin.Frame(name, joint, 0, placement, pin.FrameType.OP_FRAME)))
    data = pm.createData()
    gravity = np.array(model.spec.gravity_m_s2)

    def deflection_rate(x, v, angle, speed, rise):
        full, full_rate = np.zeros(pm.nq), np.zeros(pm.nv)
        full[drives] += angle
        full_rate[drives] += speed
        full[flex] += x
        full_rate[flex] += v
        M = pin.crba(pm, data, full)
        M = np.triu(M) + np.triu(M, 1).T
        h = pin.nonLinearEffects(pm, data, full, full_rate)[flex]
        h = h + M[np.ix_(flex, drives)] @ rise
        force = -h - assembly.stiffness @ x - assembly.damping_total @ v
        return np.linalg.solve(M[np.ix_(flex, flex)], force), full, full_rate

    step = 1 / rate
    x, v = model.static_deflection(q), np.zeros(model.n_dof)
    angle, speed = np.array(q), np.zeros(model.n_joints)
    readings = []
    for now, then in pairwise(acceleration):
        a, full, full_rate = deflection_rate(x, v, angle, speed, now)
        full_rise = np.zeros(pm.nv)
        full_rise[drives] += now
        full_rise[flex] += a
        pin.forwardKinematics(pm, data, full, full_rate, full_rise)
        pin.updateFramePlacements(pm, data)
        row = []
        for frame, channel in zip(frames, channels, strict=True):
            local = pin.getFrameClassicalAcceleration(
                pm, data, frame, pin.ReferenceFrame.LOCAL
            ).linear
            local = local - data.oMf[frame].rotation.T @ gravity
            row.append(local @ np.array(channel.direction))
        readings.append(row)
        middle = (now + then) / 2

        def rates(dt, dx, dv, rise, angle=angle, speed=speed, x=x, v=v, now=now):
            moved = angle + dt * speed + dt**2 / 2 * now
            return deflection_rate(x + dx, v + dv, moved, speed + dt * (now + rise) / 2, rise)[0]

        k1 = a
        k2 = rates(step / 2, step / 2 * v, step / 2 * k1, middle)
        k3 = rates(step / 2, step / 2 * (v + step / 2 * k1), step / 2 * k2, middle)
        k4 = rates(step, step * (v + step / 2 * k2), step * k3, then)
        x = x + step * v + step**2 / 6 * (k1 + k2 + k3)
        v = v + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        angle = angle + step * speed + step**2 * (now / 3 + then / 6)
        speed = speed + step * middle
    return np.array(readings)


def test_time_response_against_the_nonlinear_arm(shipped):
    """Small motion: the linear response is the nonlinear one to second order."""
    model, layout = shipped
    q = model.pose(next(iter(model.poses_controller_rad)))
    # Truncate stiff, irrelevant modes' cost: a short record with a fine step is enough.
    channels = [*layout.channels[7::6], Channel('odd', model.link_names[4], (0.6, 0.0, 0.8))]
    rate, count = 16000.0, 2400
    rng = np.random.default_rng(SEED + 5)
    knots = rng.normal(scale=0.05, size=(13, model.n_joints))
    time = np.arange(count) / rate
    acceleration = np.stack(
        [
            np.interp(time, np.linspace(0, time[-1], 13), knots[:, j])
            for j in range(model.n_joints)
        ],
        axis=1,
    )
    m = model.matrices(q)
    model.assembly.__dict__['damping_total'] = m.C
    exact = nonlinear_motion(model, q, channels, acceleration, rate)
    rest = model.static_deflection(q)
    linear = model.time_response(q, channels, acceleration, rate).output[:-1]
    moving = exact - exact[0] + linear[0]
    error = np.abs(moving - linear).max() / np.abs(linear).max()
    assert error < 0.01, (SEED, error, np.abs(rest).max())


def test_effects_at_their_neutral_value_change_nothing(shipped, poses):
    """Rigid hinge, rigid absorber of no mass, no payload, no rod, no compensator."""
    model, _ = shipped
    link, joint = model.link_names[2], model.joint_names[1]
    place, along = (0.0, 0.0, 0.2), (1.0, 0.0, 0.0)
    q = poses(model, 1, SEED + 7)[0]
    plain = model.modes(q).frequency_hz
    spec = dataclasses.replace(
        model.spec,
        masses=(*model.spec.masses, MassSpec('extra', link, 0.0)),
        compensators=(CompensatorSpec('none', joint, 0.0),),
        hinges=(HingeSpec('stiff', link, place, along, Spring()),),
        absorbers=(AbsorberSpec('light', link, place, along, 1e-12, Spring()),),
        rods=(RodSpec('soft', ((joint, 1.0),), Spring(1e-6)),),
    )
    np.testing.assert_allclose(model.replace(spec).modes(q).frequency_hz, plain, rtol=1e-9)
    hard = dataclasses.replace(
        model.spec, hinges=(HingeSpec('hard', link, place, along, Spring(1e14)),)
    )
    found = model.replace(hard).modes(q).frequency_hz[: len(plain)]
    np.testing.assert_allclose(found, plain, rtol=1e-4)


def test_a_model_travels_to_another_process(shipped, poses):
    model, _ = shipped
    q = poses(model, 1, SEED + 8)[0]
    expected = model.modes(q).frequency_hz
    again = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(again.modes(q).frequency_hz, expected)


def test_threads_share_a_model(shipped, poses):
    model, layout = shipped
    many = poses(model, 60, SEED + 9)
    alone = [model.modes(q, layout.channels).channel_shapes for q in many]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda q: model.modes(q, layout.channels).channel_shapes, many))
    for first, second in zip(alone, together, strict=True):
        np.testing.assert_allclose(second, first, atol=1e-9)


def test_one_pose_at_a_time():
    with pytest.raises(ModelError, match='one pose'):
        load_robot('generic_arm_6').modes(np.zeros((3, 6)))


def test_a_joint_that_stands_further_than_its_encoder_says(shipped, poses):
    """All that the dynamics gives at a pose is what it gives without offset where the arm is."""
    model, layout = shipped
    rows = layout.channels
    rng = np.random.default_rng(SEED)
    offset = rng.normal(0.0, 0.1, model.n_joints)
    balance = CompensatorSpec('balance', model.joint_names[1], 4e4, 0.3)
    spec = dataclasses.replace(model.spec, compensators=(balance,))
    joints = [
        dataclasses.replace(item, offset_rad=float(own))
        for item, own in zip(spec.joints, offset, strict=True)
    ]
    straight = dataclasses.replace(model, spec=spec)
    askew = dataclasses.replace(model, spec=dataclasses.replace(spec, joints=tuple(joints)))
    for q in poses(model, 3, SEED):
        true = q + offset
        for one, other in (
            (askew.matrices(q).M, straight.matrices(true).M),
            (askew.matrices(q).K, straight.matrices(true).K),
            (askew.gravity_coupling(q), straight.gravity_coupling(true)),
            (askew.static_deflection(q), straight.static_deflection(true)),
            (askew.torque(q, offset, offset), straight.torque(true, offset, offset)),
            (askew.sensor_jacobian(q, rows), straight.sensor_jacobian(true, rows)),
        ):
            np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(other).max())


@pytest.mark.parametrize('pull', [0.0, 900.0])
def test_a_cable_resists_as_its_length_changes(shipped, poses, pull):
    """Against the length itself, worked out by rigid kinematics of a sensor at its end."""
    model, _ = shipped
    link, place, anchor, stiffness = (
        model.robot.link_names[4],
        (0.2, 0.1, 0.0),
        (0.5, 1.0, 3.0),
        4e4,
    )
    cable = CableSpec('hose', link, place, anchor, stiffness, pull)
    held = dataclasses.replace(model, spec=dataclasses.replace(model.spec, cables=(cable,)))
    still = np.zeros(len(model.joint_names))
    for q in poses(model, 3, SEED):
        change = held.gravity_coupling(q) - model.gravity_coupling(q)
        own = held.matrices(q).K - model.matrices(q).K
        # k rᵀr: one direction, the same that the motors' motion takes; what pulls resists turning.
        slope, bend = length_slopes(model, link, place, anchor, q)
        drives = [f'{joint}/drive' for joint in model.joint_names]
        rows = [model.dof_names.index(name) for name in drives if name in model.dof_names]
        seen = [number for number, name in enumerate(drives) if name in model.dof_names]
        scale = stiffness * np.abs(np.outer(slope, slope)).max()
        expected = (stiffness * np.outer(slope, slope) + pull * bend)[seen]
        np.testing.assert_allclose(change[rows], expected, atol=1e-5 * scale)
        np.testing.assert_allclose(own[np.ix_(rows, rows)], expected[:, seen], atol=1e-5 * scale)
        if not pull:
            assert np.linalg.matrix_rank(own, tol=1e-9 * np.abs(own).max()) == 1
        lifted = held.torque(q, still, still) - model.torque(q, still, still)
        np.testing.assert_allclose(lifted, pull * slope, atol=1e-6 * max(pull, 1.0))


def length_slopes(model, link, place, anchor, q):
    """First and second derivatives of the length by the joints."""
    frame = model.robot.model.getFrameId(link)
    data = model.robot.model.createData()

    def length(angles):
        pin.framesForwardKinematics(model.robot.model, data, angles)
        return np.linalg.norm(np.array(anchor) - data.oMf[frame].act(np.array(place)))

    def slope(angles, step=1e-6):
        moves = step * np.eye(len(q))
        return np.array([length(angles + e) - length(angles - e) for e in moves]) / (2 * step)

    moves = 1e-3 * np.eye(len(q))
    bend = np.array([slope(q + e) - slope(q - e) for e in moves]) / 2e-3
    return slope(q), bend


def test_a_foundation_of_nothing_is_a_spring_in_series_and_a_heavy_one_stands_still(
    shipped, poses
):
    model, layout = shipped
    (q,) = poses(model, 1, SEED)
    plain = model.modes(q, layout.channels).frequency_hz
    springs = (Spring(1e6, 1e3), *(Spring(),) * 3, Spring(1e5, 1e2), Spring())

    def on(mass):
        body = FoundationSpec(springs, mass, 0.5, (0.0, 0.0, -0.4), 0.3)
        return dataclasses.replace(model, spec=dataclasses.replace(model.spec, foundation=body))

    assert {'foundation/tx', 'foundation/ry'} <= set(on(500.0).dof_names)
    heavy = on(1e10).modes(q, layout.channels).frequency_hz
    np.testing.assert_allclose(heavy[2:][: len(plain)], plain, rtol=1e-4)
    light = on(1.0).modes(q, layout.channels).frequency_hz
    assert light[0] < 0.9 * plain[0]
