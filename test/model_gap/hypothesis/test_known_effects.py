"""Effects that were found go into the model's files and come out of them again."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
import yaml

from modal_core.channel import SensorLayout
from modal_core.errors import LayoutError, ModelError
from model_gap.cell.cell_model import CellModel
from model_gap.effects import CATALOGUE, Scene
from model_gap.hypothesis.hypothesis import Hypothesis
from model_gap.hypothesis.known_effects import corrected_layout, known_effects, with_known_effects
from structural_model import load_robot, save_robot
from structural_model.description import KnownEffect

TYPES = {kind.type: kind for kind in CATALOGUE}


@pytest.fixture
def scene(robot, layout):
    names = tuple(sensor.name for sensor in layout)
    return Scene(robot, names, CellModel(robot.spec, layout.channels))


def hypothesis(scene, kind, location, values, variant=''):
    empty = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0))
    return empty.with_effect(TYPES[kind](location, variant), values)


def turned_by(layout, scene, kind, values, variant=''):
    """Channel directions of the corrected layout, written and read, and of the one before."""
    found = corrected_layout(layout, hypothesis(scene, kind, 'sensor:elbow', values, variant))
    again = SensorLayout.from_mapping(yaml.safe_load(yaml.safe_dump(found.to_mapping())))
    assert again.channels == found.channels
    new = np.array([channel.direction for channel in again.channels])
    assert again.sensors[0] == layout.sensors[0]
    return new[6:9], np.array([channel.direction for channel in layout.channels])[6:9]


def test_gain_polarity_swap_and_rotation_become_sensitivities(layout, scene):
    new, old = turned_by(layout, scene, 'sensor_gain', (1.3,), 'y')
    np.testing.assert_allclose(new, np.diag([1.0, 1.3, 1.0]) @ old)
    new, old = turned_by(layout, scene, 'sensor_polarity', (), 'z')
    np.testing.assert_allclose(new, np.diag([1.0, 1.0, -1.0]) @ old)
    new, old = turned_by(layout, scene, 'sensor_axis_swap', (), 'xz')
    np.testing.assert_allclose(new, old[[2, 1, 0]])
    vector = (0.3, -0.1, 0.5)
    new, old = turned_by(layout, scene, 'sensor_rotation', vector)
    np.testing.assert_allclose(new, Rotation.from_rotvec(vector).as_matrix() @ old, atol=1e-12)


def test_corrected_layout_reads_what_the_effect_did(robot, layout, scene):
    """The model with the corrected layout predicts what the effect made of the old one.

    The gain is that of the axis as it is mounted, whichever of the two was found first.
    """
    turn, gain = ('sensor_rotation', '', (0.3, -0.1, 0.5)), ('sensor_gain', 'y', (1.3,))
    q = robot.pose('P1')
    expected = robot.rigid_jacobian(q, layout.channels)
    expected[6:9] = (
        np.diag([1.0, 1.3, 1.0]) @ Rotation.from_rotvec(turn[2]).as_matrix() @ expected[6:9]
    )
    for effects in ((turn, gain), (gain, turn)):
        fitted = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0))
        for kind, variant, values in effects:
            fitted = fitted.with_effect(TYPES[kind]('sensor:elbow', variant), values)
        new = corrected_layout(layout, fitted)
        np.testing.assert_allclose(robot.rigid_jacobian(q, new.channels), expected, atol=1e-12)
        cell = fitted.cell()
        bare = robot.rigid_jacobian(q, cell.channels).astype(complex)
        seen = cell.seen(np.zeros(bare.shape[1]), bare)
        np.testing.assert_allclose(seen.real, expected, atol=1e-12)


def test_delay_is_kept_in_the_layout_and_applied_again(robot, layout, scene):
    fitted = hypothesis(scene, 'sensor_delay', 'sensor:elbow', (0.004,))
    new = SensorLayout.from_mapping(corrected_layout(layout, fitted).to_mapping())
    assert [sensor.delay_s for sensor in new] == [0.0, 0.0, 0.004, 0.0]
    cell = with_known_effects(Scene(robot, scene.sensors, CellModel(robot.spec, new.channels)))
    omega = 2.0 * np.pi * np.array([10.0, 40.0])
    flat = np.ones((12, 2), dtype=complex)
    expected = flat.copy()
    expected[6:9] *= np.exp(-1j * omega * 0.004)
    for step in cell.outputs:
        flat = step(omega, flat)
    np.testing.assert_allclose(flat, expected)


@pytest.mark.parametrize('details', [False, True])
@pytest.mark.parametrize('kind', [kind for kind in TYPES if not kind.startswith('sensor_')])
def test_every_effect_of_the_arm_is_there_again_after_loading(
    kind, details, robot, layout, scene, tmp_path
):
    scene = dataclasses.replace(scene, lines_hz=(22.0,))
    effect = TYPES[kind].instances(scene)[0]
    values = tuple(effect.starts(scene)[0])
    fitted = hypothesis(scene, kind, effect.location, values, effect.variant)
    if details:
        fitted = fitted.with_details()
        if fitted is None:
            return
        moved = fitted.inner + 0.01 * fitted.prior_scale
        fitted = dataclasses.replace(fitted, inner=moved)
        (values,) = fitted.values()
    (known,) = known_effects(fitted, 0.01 * np.eye(len(values)))
    applied = fitted.cell()
    only_arm = applied.spec != robot.spec and not applied.inputs
    assert known.kept_in == ('model' if only_arm else 'effects')
    model = robot.replace(dataclasses.replace(applied.spec, effects=(known,)))
    save_robot(model, tmp_path)
    loaded = load_robot(tmp_path)
    assert loaded.spec.effects == (known,)
    again = with_known_effects(
        Scene(loaded, scene.sensors, CellModel(loaded.spec, layout.channels))
    )
    for part in ('forces', 'ripples', 'tones'):
        assert getattr(again, part) == getattr(applied, part)
    omega = np.array([60.0, 200.0])
    for steps, others in ((again.inputs, applied.inputs), (again.outputs, applied.outputs)):
        one, two = np.ones((12, 2), dtype=complex), np.ones((12, 2), dtype=complex)
        for step in steps:
            one = step(omega, one)
        for step in others:
            two = step(omega, two)
        np.testing.assert_array_equal(one, two)


def test_a_stop_of_a_model_that_knows_no_loss_is_lossless(robot, layout, scene):
    fitted = hypothesis(scene, 'end_stop', 'joint_1', (1e-4, 3.0)).with_details()
    (known,) = known_effects(fitted, 0.01 * np.eye(4))
    older = dataclasses.replace(known, parameters=known.parameters[:3])
    spec = dataclasses.replace(robot.spec, effects=(older,))
    cell = with_known_effects(Scene(robot, scene.sensors, CellModel(spec, layout.channels)))
    assert cell.forces[0].values == (1e-4, 3.0, 0.0, 0.0)


def test_unknown_effect_is_one_clear_line(robot, layout, scene):
    spec = dataclasses.replace(robot.spec, effects=(KnownEffect('gremlin', kept_in='effects'),))
    with pytest.raises(ModelError, match='unknown effect'):
        with_known_effects(Scene(robot, scene.sensors, CellModel(spec, layout.channels)))


def test_a_misspelt_effect_is_told_the_one_that_is_meant(scene):
    spec = dataclasses.replace(
        scene.cell.spec, effects=(KnownEffect('sensor_gian', kept_in='effects'),)
    )
    cell = dataclasses.replace(scene.cell, spec=spec)
    with pytest.raises(ModelError, match='expected sensor_gain'):
        with_known_effects(dataclasses.replace(scene, cell=cell))


@pytest.mark.parametrize(
    'change',
    [
        {'sensitivity': {'x': [1, 0, 0]}},
        {'sensitivity': {'x': [0, 0, 0], 'y': [0, 1, 0], 'z': [0, 0, 1]}},
        {'sensitivity': [1, 2, 3]},
        {
            'sensitivity': {'x': [1, 0, 0], 'y': [0, 1, 0], 'z': [0, 0, 1]},
            'rotation_quaternion': [0, 0, 0, 1],
        },
        {'delay_s': 'late'},
    ],
)
def test_bad_corrections_are_refused(change):
    with pytest.raises(LayoutError) as caught:
        SensorLayout.from_mapping({'sensors': [{'name': 'a', 'frame_id': 'link_1', **change}]})
    assert '\n' not in str(caught.value)
