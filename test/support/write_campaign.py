"""Write hidden records as a campaign folder of MCAP recordings."""

import numpy as np
import yaml

from modal_core.measurements import JointSamples, SampleBlock
from modal_recordings import RecordingWriter
from modal_recordings.messages import encode

START_NS = 1_700_000_000_000_000_000


def write_campaign(folder, records, joint_names, sensors, split=True):
    folder.mkdir(parents=True, exist_ok=True)
    names = tuple(f'{sensor[0]}.{axis}' for sensor in sensors for axis in 'xyz')
    entries = []
    for record in records:
        with RecordingWriter(folder / f'{record.name}.mcap') as writer:
            size = 250
            messages = []
            for first in range(0, len(record.acceleration), size):
                rows = record.acceleration[first : first + size]
                stamp = START_NS + round(first / record.rate_hz * 1e9)
                block = SampleBlock(
                    'acceleration_block',
                    stamp,
                    first,
                    record.rate_hz,
                    names,
                    rows.astype(np.float32),
                )
                messages += encode(block, 'acceleration_block')
            stamps = START_NS + np.rint(
                np.arange(len(record.position)) / record.joint_rate_hz * 1e9
            ).astype(np.int64)
            joints = JointSamples(stamps, tuple(joint_names), record.position, record.velocity)
            messages += encode(joints, '/joint_states')
            for message in sorted(messages, key=lambda item: item.log_time_ns):
                writer.write(
                    message.topic, message.message_type, message.log_time_ns, message.data
                )
        entry = {
            'file': f'{record.name}.mcap',
            'pose': [float(a) for a in record.pose],
            'level': int(record.level),
        }
        if split:
            entry['heldout'] = bool(record.heldout)
        entries.append(entry)
    layout = [{'name': n, 'frame_id': link, 'position_m': list(p)} for n, link, p in sensors]
    (folder / 'campaign.yaml').write_text(yaml.safe_dump({'recordings': entries}))
    (folder / 'sensors.yaml').write_text(yaml.safe_dump({'sensors': layout}))
