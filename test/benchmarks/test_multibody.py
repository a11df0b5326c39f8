"""The multibody engine against analysis: it is an independent truth only if it is right.

Needs MuJoCo (the ``bench`` environment).
"""

import dataclasses

import numpy as np
import pytest
import scipy.linalg

pytest.importorskip('mujoco')

from benchmarks.gap.multibody import campaign, laws
from benchmarks.gap.multibody.compiled import compiled
from benchmarks.gap.multibody.description import read
from benchmarks.gap.multibody.faults import spoil
from benchmarks.gap.multibody.hidden import draw, KINDS, law_of, put
from benchmarks.gap.multibody.simulate import Motion, Run, simulate, STEP_S
from modal_core.files.share import share_path
from model_gap.cell import CellModel
from model_gap.effects import Scene
from model_gap.effects.cable import Cable
from model_gap.effects.foundation_mode import FoundationMode
from model_gap.effects.rod_spring import RodSpring
from structural_model import load_robot

POSE = np.array([0.3, 0.4, -0.2, 0.5, -0.6, 0.3])
STILL = Motion(np.zeros((3, 6)), np.zeros((3, 6)))
ROBOT = 'irb6660_205_190'
BRIEF = campaign.Conditions(n_fit=1, n_held=0, duration_s=0.9, noise=0.0)


def arm_of(*cases):
    description = read(share_path('config', 'robots', ROBOT))
    for case in cases:
        put(case, description)
    sensors, _ = campaign.sensors_of(cases, campaign.Conditions(), np.random.default_rng(0))
    return compiled(description, sensors)


def frequencies(arm, pose=POSE, laws=()):
    """Return the natural frequencies of the engine's own equations about rest [Hz]."""
    run = Run(arm, laws, pose, STILL, STEP_S)
    state, size = run.at_rest(), 1e-7
    around = [size * way for way in np.eye(run.size)]
    slopes = np.array([run.rate(0, state + d) - run.rate(0, state - d) for d in around]).T
    found = scipy.linalg.eigvals(slopes / (2.0 * size))
    return np.sort(np.abs(found[found.imag > 1.0])) / (2.0 * np.pi)


def test_frequencies_agree_with_the_structural_model():
    """Two formulations, one arm: below 60 Hz to 0.1 %, all that sag may shift."""
    own = frequencies(arm_of())
    model = load_robot(ROBOT).damped_modes(POSE, ()).frequency_hz
    below = np.sort(model[model < 60.0])
    np.testing.assert_allclose(own[: len(below)], below, rtol=1e-3)


def effect_of(case):
    """Return the catalogue's effect of a case, and its numbers."""
    kind = case['type']
    if kind == 'rod_spring':
        return RodSpring(case['place'], '-'), (case['k'], 3e-4)
    if kind == 'cable':
        return Cable(case['place']).detailed(), (case['k'], *case['anchor'], *case['at'])
    rocks = case['way'][0] == 'r'
    mass = case['mass'] * (case['gyration'] ** 2 if rocks else 1.0)
    way = f'{"about" if rocks else "along"} {case["way"][1]}'
    return FoundationMode(None, way), (1.0 / mass, case['f'], case['zeta'])


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('kind', ['rod_spring', 'cable', 'foundation_mode'])
def test_what_is_hidden_is_what_the_catalogue_means(kind, seed):
    """Random numbers and poses: below 60 Hz to 0.1 % with the effect, 0.1 to 50 % off without."""
    rng = np.random.default_rng([82, seed])
    case = draw(kind, rng, campaign.SENSOR_NAMES)
    pose = np.array(campaign.CENTRE) + np.array(campaign.SPREAD) * rng.uniform(-1.0, 1.0, 6)
    arm, model = arm_of(case), load_robot(ROBOT)
    law = law_of(case, arm, pose, 1.0, rng)
    own = frequencies(arm, pose, () if law is None else (law,))
    scene = Scene(model, (), CellModel(model.spec, ()))
    effect, values = effect_of(case)
    spec = effect.apply(scene.cell, values, scene).spec
    said = np.sort(dataclasses.replace(model, spec=spec).damped_modes(pose, ()).frequency_hz)
    below = said[said < 60.0]
    np.testing.assert_allclose(own[: len(below)], below, rtol=1e-3, err_msg=f'seed {seed}: {case}')


def test_at_rest_every_sensor_reads_gravity():
    arm = arm_of()
    readings = simulate(arm, (), POSE, Motion(np.zeros((21, 6)), np.zeros((21, 6))))
    lengths = np.linalg.norm(readings.reshape(len(readings), -1, 3), axis=2)
    np.testing.assert_allclose(lengths, 9.81, rtol=1e-9)


@pytest.mark.parametrize('seed', range(6))
def test_a_gear_with_play_leans_on_a_flank_before_a_record_begins(seed):
    """Random joints and poses: a thousandth of what 0.2 mrad of the drive's spring would hold."""
    rng = np.random.default_rng([79, seed])
    case = draw('backlash', rng, campaign.SENSOR_NAMES)
    arm = arm_of(case)
    pose = np.array(campaign.CENTRE) + np.array(campaign.SPREAD) * rng.uniform(-1.0, 1.0, 6)
    law = law_of(case, arm, pose, 1.0, rng)
    run = Run(arm, (law,), pose, STILL, STEP_S)
    state = run.at_rest()
    left = run.rate(0, state)[run.n : 2 * run.n] @ run.mass
    assert np.abs(left).max() < 2e-7 * law.k, f'seed {seed}: {case}'
    assert np.abs(state[arm.drives] - pose).max() < 5e-3, f'seed {seed}: {case}'


def test_a_cable_pulls_alike_in_every_pose():
    """The arm hangs a little lower than it was tied: the pull is less by what that makes."""
    case = draw('cable', np.random.default_rng(80), campaign.SENSOR_NAMES)
    arm = arm_of(case)
    for turned in (-0.5, 0.5):
        run = Run(arm, (), POSE + turned, STILL, STEP_S)
        run.rate(0, run.at_rest())
        longer = run.data.ten_length[0] - arm.model.tendon_lengthspring[0, 0]
        assert abs(case['k'] * longer - case['pull']) < case['k'] * 2e-3, turned


def test_a_rod_couples_twists_and_does_not_hold_the_motors():
    """Joints 2 and 3 twisted alike do not stretch a rod over their difference."""
    arm = arm_of()
    case = {'type': 'rod_spring', 'place': 'joint_2+joint_3', 'k': 2e6}
    rod = law_of(case, arm, POSE, 1.0, np.random.default_rng(0))
    for joints, held in (([0, 1, 1, 0, 0, 0], 0.0), ([0, 1e-3, -1e-3, 0, 0, 0], -4e3)):
        torque = arm.couple.T @ rod.at_rest(arm.couple @ np.array(joints, float))
        np.testing.assert_allclose(torque, held * np.array([0, 1, -1, 0, 0, 0]), atol=1e-6)


@pytest.mark.parametrize('kind', ['payload', 'encoder_offset', 'tonal_disturbance'])
def test_an_arm_that_stands_still_reads_what_a_campaign_does_on_the_mean(kind):
    """Of a brief one; a hum has no mean, and motion adds some hundredths of m/s²."""
    case, folder = (
        draw(kind, np.random.default_rng(3), ('frame',)),
        share_path('config', 'robots', ROBOT),
    )
    moving = campaign.make_records(folder, [case], 4, BRIEF)[0]
    still = campaign.still_records(folder, [case], 4, BRIEF)[0]
    np.testing.assert_array_equal(still.acceleration, still.acceleration[:1].repeat(8, axis=0))
    mean = moving.acceleration.mean(axis=0)
    np.testing.assert_allclose(still.acceleration[0], mean, atol=0.2)


def test_compliance_under_the_base_is_in_series():
    """Both rocking springs of the plate and of the base carry the same moment."""
    soft = 1e-6
    case = {'type': 'base_compliance', 'place': None, 'compliance': soft, 'loss': 4e-4}
    lowest = frequencies(arm_of(case))[0]
    stiff = frequencies(arm_of())[0]
    assert lowest < 0.7 * stiff


def test_motors_shake_about_their_pose_and_do_not_wander():
    """A pose that wanders by degrees is no recording at one pose (seeds 0 to 9)."""
    for seed in range(10):
        motion = campaign.motion_of(10.0, 1.0, np.random.default_rng(seed))
        assert np.abs(motion.position).max() < np.radians(1.0)
        assert np.abs(motion.velocity[[0, -1]]).max() < 1e-9


def test_a_stiffer_joint_is_that_factor():
    case = {'type': 'joint_stiffness', 'place': 'joint_2', 'factor': 1.5}
    changed, plain = arm_of(case), arm_of()
    np.testing.assert_allclose(changed.k / plain.k, [1, 1.5, 1, 1, 1, 1])


@pytest.fixture(scope='module')
def plain():
    """What an arm without anything hidden shows (seed 5)."""
    return campaign.make_records(share_path('config', 'robots', ROBOT), [], 5, BRIEF)[-1]


@pytest.mark.parametrize('kind', sorted(KINDS))
def test_every_kind_changes_what_is_recorded(kind, plain):
    folder, rng = share_path('config', 'robots', ROBOT), np.random.default_rng([5, *kind.encode()])
    case = draw(kind, rng, campaign.SENSOR_NAMES)
    if kind == 'knocks':
        case['per_s'] = 20.0  # some, in so short a time
    changed = campaign.make_records(folder, [case], 5, BRIEF)[-1].acceleration
    assert np.all(np.isfinite(changed))
    own = plain.acceleration  # play on one flank hardly shows in so short a time
    assert np.abs(changed - own).max() > 1e-5 * np.abs(own - own.mean(axis=0)).max()


def test_a_mount_is_the_mass_on_a_spring_that_it_is_said_to_be():
    """Within the compared band to 0.2 % of its transfer function, resonances from 65 Hz on."""
    rate, count = 500.0, 4000
    times = np.arange(count) / rate
    window = np.sin(np.pi * times / times[-1]) ** 2
    for resonance in (65.0, 90.0, 160.0):
        case = {'type': 'sensor_mount_resonance', 'f': resonance, 'zeta': 0.05}
        for shaken in (10.0, 30.0, 59.0):
            base = window * np.sin(2.0 * np.pi * shaken * times)
            read = spoil(case, base[:, None], rate, [0], np.random.default_rng(0))[:, 0]
            seen = window * np.exp(-2j * np.pi * shaken * times)
            ratio = shaken / resonance
            said = (1.0 + 0.1j * ratio) / (1.0 - ratio**2 + 0.1j * ratio)
            assert abs(read @ seen / (base @ seen) / said - 1.0) < 2e-3, (resonance, shaken)


def test_bristles_slide_at_their_level_and_give_way_before():
    law = laws.Friction(0, 1e6, level=100.0, bristle=5e7)
    force, step = np.zeros(1), 1e-5
    for number in range(2000):
        still = np.zeros(6)
        rate = np.full(6, 1e-2)
        torque, change = law.torque(number * step, still, rate, still, still, force)
        force = force + step * change
        if number == 1:
            assert torque[0] == pytest.approx(-5e7 * 1e-2 * step, rel=0.1)
    assert force[0] == pytest.approx(100.0, rel=1e-3)


def test_play_carries_nothing_between_its_flanks():
    law = laws.Play(0, 1e6, half=1e-4, c=200.0)
    zeros = np.zeros(6)
    for twist, carried in ((5e-5, 0.0), (3e-4, 200.0), (-3e-4, -200.0)):
        e = np.full(6, twist)
        torque, _ = law.torque(0.0, e, zeros, zeros, zeros, np.zeros(0))
        assert 1e6 * twist - torque[0] == pytest.approx(carried, abs=1e-9)


def test_a_smooth_slip_carries_no_more_than_its_share():
    """Wen's spring: pulled far enough it carries share * k * limit."""
    law, state, step = laws.BoucWen(0, 1e6, share=0.3, limit=5e-5), np.zeros(1), 1e-4
    still = np.zeros(6)
    for _ in range(5000):
        torque, change = law.torque(0.0, still, np.full(6, 2e-3), still, still, state)
        state = state + step * change
    assert torque[0] == pytest.approx(-0.3 * 1e6 * 5e-5, rel=1e-3)


def test_laws_have_their_places():
    """Every torque law belongs to a kind, and is in the gear it was drawn for."""
    arm = arm_of()
    rng = np.random.default_rng(3)
    for kind in KINDS:
        case = draw(kind, rng, campaign.SENSOR_NAMES)
        law = law_of(case, arm, POSE, 1.0, rng)
        if law is not None and kind != 'servo_compliance':
            assert case['place'].endswith(f'joint_{law.gear + 1}')
