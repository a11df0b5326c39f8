"""Which responses an identifier takes for its own, where cells share a domain."""

import pytest

from oma_identifier.node.cell_topics import is_of_cell

CELLS = ('/', '/hall/cell_1', '/hall/cell_10')


@pytest.mark.parametrize(
    ('topic', 'namespace', 'own'),
    [
        ('/acceleration_block', '/', True),
        ('/drivers/imu/elbow', '/', True),
        ('/hall/imu/door', '/', True),
        ('/hall/cell_1/acceleration_block', '/', False),
        ('/hall/cell_1/imu/elbow', '/hall/cell_1', True),
        ('/hall/cell_10/imu/elbow', '/hall/cell_1', False),
        ('/imu/elbow', '/hall/cell_1', False),
        ('/hall/imu/door', '/hall', True),
        ('/hall/cell_10/imu/elbow', '/hall', False),
    ],
)
def test_a_topic_is_of_the_cell_whose_namespace_it_is_in(topic, namespace, own):
    assert is_of_cell(topic, namespace, CELLS) == own
