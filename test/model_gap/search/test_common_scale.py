"""What no motion tells: masses, springs and dampers that all are so much larger."""

import numpy as np

from modal_core.channel import SensorLayout
from model_gap.campaign import Campaign, GapRecord
from model_gap.fit.linearise import tolerance_columns
from model_gap.search.search import Search
from test.support.planar_arm import planar_arm

SEED = 61
RATE_HZ, SECONDS = 400.0, 6.0


def campaign(model):
    """One recording that ends while the arm rings; what was read does not matter."""
    rng = np.random.default_rng(SEED)
    count = round(RATE_HZ * SECONDS)
    motion = rng.normal(size=(count, 3))
    layout = SensorLayout.from_mapping(
        {
            'sensors': [
                {'name': f's{n}', 'frame_id': f'l{n}', 'position_m': [0.2, 0.05, 0.0]}
                for n in (1, 2, 3)
            ]
        }
    )
    record = GapRecord(
        name='one',
        pose=np.array([0.2, 0.7, -0.5]),
        level='1',
        sample_rate_hz=RATE_HZ,
        acceleration=rng.normal(size=(count, len(layout.channels))),
        motor_acceleration=motion,
        motor_velocity=np.cumsum(motion, axis=0) / RATE_HZ,
        motor_shift=np.zeros((count, 3)),
        heldout=False,
    )
    return Campaign((record,), layout, model.joint_names)


def test_masses_springs_and_dampers_together_change_nothing(tmp_path):
    """Fits move freely along that line, and σ across it is what is known before."""
    model = planar_arm(tmp_path / 'arm')
    search = Search.begin(model, campaign(model))
    columns = tolerance_columns(search.nominal, search.data.fitting).astype(float)
    scale = np.zeros(len(columns))
    for number, item in enumerate(search.tolerances):
        if item.name.startswith(('stiffness of', 'damping of', 'mass of')):
            scale[number] = 0.01 / item.sigma
    assert np.count_nonzero(scale) == 9
    alone = np.linalg.norm(scale[:, None] * columns)
    assert np.linalg.norm(scale @ columns) < 1e-3 * alone, f'seed {SEED}'
