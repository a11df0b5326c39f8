"""Nonlinear joints: what small changes feel of them, and play tried on the measured twist."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel, HeldTorque
from model_gap.cell.tolerances import nuisances, Tolerances
from model_gap.effects import Scene
from model_gap.effects.backlash import Backlash
from model_gap.effects.base_compliance import BaseCompliance
from model_gap.effects.coulomb_friction import CoulombFriction
from model_gap.effects.cubic_damping import CubicDamping
from model_gap.effects.cubic_stiffness import CubicStiffness
from model_gap.effects.end_stop import EndStop
from model_gap.effects.hysteresis import Hysteresis
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.sensor_gain import SensorGain
from model_gap.find_gap import find_gap
from model_gap.fit.linearise import effect_columns, tolerance_columns
from model_gap.hypothesis.hypothesis import Hypothesis
from model_gap.predict.error_covariance import error_covariance, whitened
from model_gap.predict.followed import PARTING_1_S, parting_residues, predicted_share
from model_gap.predict.predict import Predictor
from model_gap.search.search import SearchSettings
from structural_model.description import BaseSpec

SEED = 17
SMALL = {'n_fit': 2, 'n_held': 0, 'duration': 10.0, 'size': 0.0}


def test_parting_filter_is_its_partial_fractions():
    s = 1j * np.geomspace(1.0, 300.0, 40)
    parts = np.sum(parting_residues() / (s[:, None] + PARTING_1_S), axis=1)
    np.testing.assert_allclose(predicted_share(s), parts, rtol=1e-9, atol=1e-12)
    assert abs(predicted_share(s)[0]) == pytest.approx(1.0, abs=1e-3)
    assert abs(predicted_share(s)[-1]) < 0.3


def predictor_of(campaign, robot, **options):
    spectra = [record_spectra(item, Band(4.0, 50.0), 90) for item in campaign.records]
    cell = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    names = tuple(sensor.name for sensor in campaign.layout)
    predictor = Predictor(robot, spectra, hanging=False, **options)
    return predictor, Scene(robot, names, cell)


def test_play_is_explained_where_no_motion_can_be_predicted(campaign_of, robot):
    # Without gravity on it joint 1 floats in its play: the motion is chaotic.
    hidden = {'type': 'backlash', 'joint': 'joint_1', 'gap': 1.5e-4}
    campaign = campaign_of([hidden], SEED, **SMALL)
    predictor, scene = predictor_of(campaign, robot)

    def left(gap):
        cell = Backlash('joint_1').apply(scene.cell, (gap, 1.0), scene) if gap else scene.cell
        return predictor.weighting.misfit(predictor.rows(cell))

    right = left(1.5e-4)
    assert right < 2.0, f'seed {SEED}: {right:.2f}'
    assert left(0.0) > 50.0 * right, f'seed {SEED}: {left(0.0):.1f}'
    assert left(1.2e-4) > 2.0 * right, f'seed {SEED}: {left(1.2e-4):.1f}'
    assert left(1.9e-4) > 2.0 * right, f'seed {SEED}: {left(1.9e-4):.1f}'


def test_error_covariance_takes_along_its_direction_only_and_costs_its_determinant(
    campaign_of, robot
):
    predictor, _ = predictor_of(campaign_of([], SEED, **SMALL), robot)
    item = predictor.records[0]
    rng = np.random.default_rng(SEED)
    shape = item.measured.shape
    response = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    error = 0.3 * np.ones(shape[1])
    covariance = error_covariance([response], [error], item)
    size = np.sum(np.abs(response) ** 2 / item.noise_power, axis=0)
    assert covariance.log_det == pytest.approx(np.log1p(0.09 * size).sum())
    along = whitened(response, covariance, item)
    np.testing.assert_allclose(along, response / np.sqrt(1.0 + 0.09 * size), rtol=1e-9)
    other = rng.standard_normal(shape) + 0j
    inner = np.sum(response.conj() * other / item.noise_power, axis=0)
    other = other - response * (inner / size)
    np.testing.assert_allclose(whitened(other, covariance, item), other, atol=1e-9)


def test_numbers_of_a_held_law_stay(campaign_of, robot):
    predictor, scene = predictor_of(campaign_of([], SEED, **SMALL), robot)
    start = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0))
    one = start.with_effect(CubicStiffness('joint_2'), (1e5, 1.0))
    held = replace(one, held=predictor.hold(one.cell()).held)
    two = held.with_effect(Backlash('joint_3'), (1e-4, 1.0))
    moved = two.moved(two.tolerance_values, two.inner + 0.1)
    np.testing.assert_array_equal(moved.inner[:2], two.inner[:2])
    np.testing.assert_allclose(moved.inner[2:], two.inner[2:] + 0.1)
    assert one.moved(one.tolerance_values, one.inner + 0.1).inner[0] == one.inner[0] + 0.1


@pytest.mark.parametrize(
    ('joint', 'alpha', 'share'),
    [
        pytest.param('joint_2', 1e5, 0.0, marks=pytest.mark.slow),
        pytest.param('joint_2', 1e6, 1.0, marks=pytest.mark.slow),
        ('joint_3', 4e6, 0.0),
    ],
)
def test_tolerance_derivatives_follow_a_hard_spring(joint, alpha, share, campaign_of, robot):
    """Those of its own drive, of other drives, and through the preload what gravity pulls on.

    The hardest one stiffens its drive to more than twice as it moves.
    """
    hidden = {'type': 'cubic_stiffness', 'joint': joint, 'alpha': alpha, 'preload': share}
    campaign = campaign_of([hidden], SEED, **SMALL)
    predictor, scene = predictor_of(campaign, robot)
    found = derivative_errors(predictor, scene, CubicStiffness(joint), (alpha, share))
    assert max(found.values()) < 0.1, f'seed {SEED}: {found}'


@pytest.mark.slow
@pytest.mark.parametrize(
    ('effect', 'values'),
    [
        (EndStop('joint_1'), (8e-5, 3.0)),
        (Hysteresis('joint_2'), (0.5, 3e-5)),
        (CubicDamping('joint_2'), (3e8,)),
        (CoulombFriction('joint_2'), (80.0, 1e-3)),
    ],
)
def test_tolerance_derivatives_follow_any_law(effect, values, campaign_of, robot):
    predictor, scene = predictor_of(campaign_of([], SEED, **SMALL), robot)
    found = derivative_errors(predictor, scene, effect, values)
    assert max(found.values()) < 0.1, f'seed {SEED}: {found}'


def derivative_errors(predictor, scene, effect, values):
    """Return how far derivatives are from central differences, over their size, by tolerance."""
    tolerances = nuisances(scene.cell, ('link_3',), Tolerances())
    start = Hypothesis(scene, tolerances, (), np.zeros(len(tolerances)), np.zeros(0))
    bent = start.with_effect(effect, values)
    columns = tolerance_columns(bent, predictor)
    step = 0.02
    wanted = [
        f'{what} of {place}'
        for what, place in (
            ('stiffness', 'joint_2'),
            ('damping', 'joint_2'),
            ('stiffness', 'joint_3'),
            ('stiffness', 'joint_5'),
            ('mass', 'link_3'),
        )
    ] + ['centre of mass of link_3 (x)']
    found = {}
    for number, item in enumerate(tolerances):
        if item.name not in wanted:
            continue
        up, down = (
            predictor.weighting.rows(
                predictor.predict(
                    bent.moved(np.eye(len(tolerances))[number] * sign * step, bent.inner).cell()
                )
            )
            for sign in (1.0, -1.0)
        )
        exact = (up - down) / (2.0 * step)
        found[item.name] = float(np.linalg.norm(columns[number] - exact) / np.linalg.norm(exact))
    assert sorted(found) == sorted(wanted)
    return found


@pytest.mark.slow
def test_search_finds_a_hard_spring_under_gravity(campaign_of, robot):
    """Preload bends it more than the motion does: to a linear search it is a stiffer joint."""
    hidden = {'type': 'cubic_stiffness', 'joint': 'joint_2', 'alpha': 6e5, 'preload': 1.0}
    campaign = campaign_of([hidden], SEED, n_fit=3, n_held=1, duration=8.0)
    catalogue = (JointStiffness, Backlash, CubicStiffness)
    result = find_gap(robot, campaign, SearchSettings(catalogue=catalogue, most_effects=1))
    best = result.search.rounds[0].candidates[0]
    (effect,) = best.fit.hypothesis.effects
    assert effect.key == ('cubic_stiffness', 'joint_2'), f'seed {SEED}: {effect}'
    ((alpha, share),) = best.fit.hypothesis.values()
    sigma = np.sqrt(np.diag(best.fit.covariance))
    assert abs(alpha - 6e5) < 3.0 * sigma[0], f'seed {SEED}: {alpha} ± {sigma[0]}'
    assert abs(share - 1.0) < 3.0 * sigma[1], f'seed {SEED}: {share} ± {sigma[1]}'
    assert best.heldout_misfit < 2.0, f'seed {SEED}: {best.heldout_misfit}'


def test_error_covariance_of_play_stays_while_its_torque_is_held(campaign_of, robot):
    """What an effect beside play changes is as uncertain as the prediction itself."""
    campaign = campaign_of([], SEED, **SMALL)
    spectra = [record_spectra(item, Band(4.0, 50.0), 100) for item in campaign.records]
    predictor = Predictor(robot, spectra, hanging=False)
    cell = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    names = tuple(sensor.name for sensor in campaign.layout)
    nominal = Hypothesis(Scene(robot, names, cell), (), (), np.zeros(0), np.zeros(0))
    play = nominal.with_effect(Backlash('joint_3'), (6e-5, 1.0))
    gain = next(iter(SensorGain.instances(nominal.scene)))
    both = play.with_effect(gain, (1.1,))
    base = predictor.rows(both.cell())
    held = predictor.hold(both.cell())
    assert np.linalg.norm(predictor.rows(held) - base) < 1e-6 * np.linalg.norm(base)

    def rows(step):
        inner = both.inner + np.r_[0.0, 0.0, step] * both.prior_scale
        moved = both.moved(both.tolerance_values, inner).cell()
        return predictor.rows(replace(moved, forces=(), held=held.held))

    expected = (rows(0.02) - rows(-0.02)) / 0.04
    wrong = np.linalg.norm(effect_columns(both, predictor, base)[-1] - expected)
    assert wrong < 0.02 * np.linalg.norm(expected), f'seed {SEED}'


def test_a_rigid_base_is_let_go_step_by_step(campaign_of, robot):
    """Sideways it is rigid where it rocks already: a step from there has more motions."""
    rigid = robot.replace(replace(robot.spec, base=BaseSpec()))
    campaign = campaign_of([], SEED, **SMALL)
    predictor, scene = predictor_of(campaign, rigid)
    nominal = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0))
    rocking = nominal.with_effect(BaseCompliance(None), (1e-7, 4e-4)).with_details()
    columns = effect_columns(rocking, predictor, predictor.rows(rocking.cell()))
    assert [item.name for item in rocking.parameters][-1] == 'translation'
    assert np.isfinite(columns).all() and np.linalg.norm(columns[-1]) > 0.0


def test_numbers_move_beside_held_torques_of_the_model_itself(robot, layout):
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    scene = Scene(robot, tuple(sensor.name for sensor in layout), cell)
    known = Backlash('joint_2').apply(cell, (1e-4, 1.0), scene)
    scene = replace(scene, cell=known)
    held = (HeldTorque((), ()),)
    nominal = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0), held)
    play = nominal.with_effect(Backlash('joint_3'), (1e-4, 1.0))
    moved = play.moved(play.tolerance_values, 1.5 * play.inner)
    assert moved.inner == pytest.approx(1.5 * play.inner)
    second = replace(play, held=(*held, *held)).with_effect(Backlash('joint_1'), (1e-4, 1.0))
    moved = second.moved(second.tolerance_values, 1.5 * second.inner)
    assert moved.inner[:2] == pytest.approx(second.inner[:2])
    assert moved.inner[2:] == pytest.approx(1.5 * second.inner[2:])
