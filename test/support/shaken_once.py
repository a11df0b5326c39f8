"""One recording of a planar arm that is shaken."""

import numpy as np

from modal_core.channel import SensorLayout
from model_gap.campaign import Campaign, GapRecord

RATE_HZ, SECONDS = 400.0, 6.0


def shaken_once(model, seed, until_s=SECONDS):
    """Return a campaign of one recording; what was read does not matter.

    Shaken to its end it ends while the arm rings.
    """
    rng = np.random.default_rng(seed)
    count = round(RATE_HZ * SECONDS)
    motion = rng.normal(size=(count, 3))
    motion[round(RATE_HZ * until_s) :] = 0.0
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
