"""Every effect of the catalogue: neutral does nothing, more does something, words are there."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.effects import CATALOGUE, Scene
from model_gap.predict.predict import Predictor

NEEDED = {
    'payload', 'joint_stiffness', 'joint_damping', 'base_compliance', 'link_flexibility',
    'rod_spring', 'coulomb_friction', 'backlash', 'cubic_stiffness', 'speed_dependent_stiffness',
    'transmission_error', 'tonal_disturbance', 'servo_compliance', 'tuned_mass', 'command_delay',
    'sensor_gain', 'sensor_polarity', 'sensor_axis_swap', 'sensor_rotation', 'sensor_delay',
    'sensor_mount_resonance', 'sensor_mass', 'encoder_offset', 'sensor_position', 'sensor_unit',
    'gravity_compensator', 'foundation_mode', 'cable', 'hysteresis', 'end_stop', 'cubic_damping',
    'stribeck_friction', 'load_friction', 'stiffness_drift', 'clock_drift',
}  # fmt: skip
# Values at which an effect does nothing, where its parameters' neutral values are not that.
HARMLESS = {
    'coulomb_friction': (1e-9, 1e-3),
    'stribeck_friction': (1e-9, 1e-3, 1.0, 5e-3),
    'load_friction': (1e-9, 1e-3, 0.0),
    'backlash': (1e-12, 1.0),
    'end_stop': (1e-2, 3.0),
    'cubic_damping': (1.0,),
    'sensor_mount_resonance': (3e6, 0.05),
    'servo_compliance': (3e5, 0.5),
    'tuned_mass': (1e-7, 15.0, 0.04),
    'foundation_mode': (0.0, 15.0, 0.04),
    'payload': (1e-9, 0.0, 0.0, 0.0, 0.06),
    'base_compliance': (1e-14, 4e-4),
    'link_flexibility': (1e-14, 4e-4),
    'rod_spring': (1e-6, 3e-4),
    'transmission_error': (0.0, 0.0, 100.0),
}
DISCRETE = {'sensor_polarity', 'sensor_unit', 'sensor_axis_swap', 'tonal_disturbance'}


@pytest.fixture(scope='module')
def scene(robot, layout):
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    return Scene(robot, tuple(sensor.name for sensor in layout), cell, lines_hz=(23.0,))


@pytest.fixture(scope='module')
def predictor(campaign_of, robot):
    campaign = campaign_of((), 3, n_fit=1, n_held=0, duration=6.0, levels=(1.0,))
    return Predictor(robot, [record_spectra(item, Band(), 60) for item in campaign.records])


def test_catalogue_is_complete():
    assert NEEDED <= {kind.type for kind in CATALOGUE}
    assert len({kind.type for kind in CATALOGUE}) == len(CATALOGUE)


@pytest.mark.parametrize('kind', CATALOGUE, ids=lambda kind: kind.type)
def test_effect_describes_itself(kind, scene):
    effects = kind.instances(scene)
    assert effects, kind.type
    assert kind.equation and kind.source and kind.signature
    types = {other.type for other in CATALOGUE}
    assert set(kind.confused_with) <= types
    assert kind.confused_with, 'what tells it apart from others'
    for effect in effects:
        for item in effect.parameters(scene):
            assert item.low <= item.neutral <= item.high or item.log
            assert item.unit
            assert item.scale > 0.0


@pytest.mark.parametrize(
    'kind', [kind for kind in CATALOGUE if kind.type not in DISCRETE], ids=lambda kind: kind.type
)
def test_harmless_values_change_nothing(kind, scene, predictor):
    effect = kind.instances(scene)[0]
    values = HARMLESS.get(kind.type, tuple(item.neutral for item in effect.parameters(scene)))
    base = predictor.predict(scene.cell)[0]
    same = predictor.predict(effect.apply(scene.cell, values, scene))[0]
    assert np.abs(same - base).max() < 2e-4 * np.abs(base).max(), kind.type


@pytest.mark.parametrize('kind', CATALOGUE, ids=lambda kind: kind.type)
def test_every_start_is_possible_and_changes_something(kind, scene, predictor):
    effects = kind.instances(scene)
    effect = effects[len(effects) // 3]
    base = predictor.predict(scene.cell)[0]
    starts = list(effect.starts(scene))
    assert starts
    for values in starts[:: max(1, len(starts) // 3)]:
        other = predictor.predict(effect.apply(scene.cell, values, scene))[0]
        assert np.isfinite(other).all(), (kind.type, values)
        assert np.abs(other - base).max() > 1e-6 * np.abs(base).max(), (kind.type, values)


@pytest.mark.parametrize('kind', CATALOGUE, ids=lambda kind: kind.type)
def test_inner_scale_is_invertible(kind, scene):
    for item in kind.instances(scene)[0].parameters(scene):
        middle = item.neutral * 1.1 if item.log else item.neutral + 0.3 * item.scale
        middle = min(max(middle, item.low), item.high)
        assert item.value(item.inner(middle)) == pytest.approx(middle)


@pytest.mark.parametrize('kind', CATALOGUE, ids=lambda kind: kind.type)
def test_parts_of_a_corrected_model_keep_their_names(kind, scene):
    """The same effect once more, on a model that has it: no two parts have one name."""
    effect = next(iter(kind.instances(scene)))
    values = tuple(effect.starts(scene)[-1])
    spec = effect.apply(effect.apply(scene.cell, values, scene), values, scene).spec
    for parts in (spec.masses, spec.absorbers, spec.hinges, spec.rods):
        names = [part.name for part in parts]
        assert len(names) == len(set(names)), names
