import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from modal_core.channel import rotate, SensorLayout
from modal_core.errors import LayoutError

ELBOW = {'name': 'elbow', 'frame_id': 'link_3', 'position_m': [0.1, 0.0, 0.2], 'axes': ['x', 'z']}


def test_a_sensor_has_one_channel_per_axis_in_the_frame_of_its_link():
    layout = SensorLayout.from_mapping({'sensors': [ELBOW]}, 'cell.yaml')
    assert [channel.name for channel in layout.channels] == ['elbow.x', 'elbow.z']
    assert layout.channels[1].direction == (0.0, 0.0, 1.0)
    assert layout.channels[1].position_m == (0.1, 0.0, 0.2)


def test_mounting_rotation_agrees_with_scipy():
    rng = np.random.default_rng(3)
    for rotation in Rotation.from_quat(rng.normal(size=(20, 4))):
        vector = rng.normal(size=3)
        np.testing.assert_allclose(
            rotate(tuple(rotation.as_quat()), tuple(vector)), rotation.apply(vector), atol=1e-12
        )


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'frame_id': None}, ['frame_id missing', 'sensors[0]']),
        ({'axes': ['w']}, ['bad axes', 'w']),
        ({'axes': ['x', 'x']}, ['bad axes']),
        ({'position_m': [1, 2]}, ['position_m', '3 numbers']),
        ({'position_m': [1, 2, float('nan')]}, ['position_m', 'nan']),
        ({'rotation_quaternion': [0, 0, 0, 2]}, ['unit quaternion', '2.0']),
        ({'colour': 'red'}, ['unknown field', 'colour']),
    ],
)
def test_a_malformed_sensor_is_named_in_one_line(change, words):
    with pytest.raises(LayoutError) as caught:
        SensorLayout.from_mapping({'sensors': [{**ELBOW, **change}]}, 'cell.yaml')
    line = str(caught.value)
    assert 'cell.yaml' in line and '\n' not in line
    for word in words:
        assert word in line


@pytest.mark.parametrize('data', [None, [], {}, {'sensors': []}, {'sensors': {}}, 3])
def test_a_layout_without_sensors_is_refused(data):
    with pytest.raises(LayoutError, match='no sensors'):
        SensorLayout.from_mapping(data, 'cell.yaml')


def test_a_name_used_twice_is_refused():
    with pytest.raises(LayoutError, match='elbow'):
        SensorLayout.from_mapping({'sensors': [ELBOW, ELBOW]}, 'cell.yaml')


def test_a_sensor_on_a_link_the_robot_lacks_is_refused():
    layout = SensorLayout.from_mapping({'sensors': [ELBOW]}, 'cell.yaml')
    layout.check_links(['link_3'], 'arm')
    with pytest.raises(LayoutError, match=r'elbow.*link_3.*link_1, link_2'):
        layout.check_links(['link_1', 'link_2'], 'arm')
