"""What is left over is described: a resonance, an amplitude, a pose, a sensor, or none."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.decide.what_remains import described, Part

SENSORS = tuple(name for name in ('frame', 'elbow', 'spindle', 'flange') for _ in 'xyz')
FREQUENCY = np.geomspace(3.0, 60.0, 120)


def parts(excess, poses=4, levels=('quiet', 'loud')):
    """Records of a response of 10 000 times the noise; excess(pose, level) is beside it."""
    whole = np.ones((len(SENSORS), len(FREQUENCY)))
    return [
        Part(pose, level, SENSORS, FREQUENCY, excess(pose, level) * whole, 1e4 * whole)
        for pose in range(1, poses + 1)
        for level in levels
    ]


def peak(hz):
    return 0.5 + 200.0 / (1.0 + ((FREQUENCY - hz) / 0.4) ** 2)


def only(sensor):
    return np.array([400.0 if name == sensor else 1.0 for name in SENSORS])[:, None]


@pytest.mark.parametrize(
    ('excess', 'said', 'advised'),
    [
        (lambda pose, level: peak(13.6), 'a resonance at 13.6 Hz', 'sensor on the base plate'),
        (lambda pose, level: 30.0 if level == 'loud' else 3.0, 'depends on amplitude', 'third'),
        (lambda pose, level: 300.0 if pose == 3 else 1.0, 'in pose 3 only', 'pose 3 once more'),
        (lambda pose, level: only('elbow'), 'what sensor elbow reads', 'mount, place and cable'),
        (lambda pose, level: 20.0, 'spread over', 'more poses'),
        # The arm's own resonances move with the pose: no one owns what stays.
        (lambda pose, level: peak(8.0 + 3.0 * pose), 'spread over', 'more poses'),
    ],
)
def test_what_is_seen_is_said_with_what_to_record_next(excess, said, advised):
    (found,) = described(parts(excess))
    assert said in found.words and advised in found.next_recording


def test_noise_alone_is_not_described():
    rng = np.random.default_rng(3)
    size = len(SENSORS), len(FREQUENCY)
    assert described(parts(lambda pose, level: -rng.random(size))) == ()


@pytest.mark.parametrize(
    ('natural_hz', 'said'), [((9.0, 13.5), 'has a natural frequency'), ((9.0,), 'no link')]
)
def test_a_resonance_that_the_model_has_is_not_said_to_be_a_strangers(natural_hz, said):
    own = [replace(it, natural_hz=np.array(natural_hz)) for it in parts(lambda *_: peak(13.6))]
    (found,) = described(own)
    assert said in found.words, found.words
