"""Modes, response and a changed model of a robot, at a pose and over its workspace.

Usage: python examples/model_of_an_arm.py [robot] [pose]
"""

import sys

import numpy as np

from structural_model import load_layout, load_robot
from structural_model.equations import random_poses


def main(robot: str = 'irb6660_205_190', pose: str = 'P1') -> None:
    model = load_robot(robot)
    channels = load_layout(robot).channels
    q = model.check_pose(model.pose(pose))

    modes = model.damped_modes(q, channels)
    print(f'{robot} at {pose}, {model.n_dof} flexible degrees of freedom')
    for frequency, damping, shape in zip(
        modes.frequency_hz, modes.damping_ratio, modes.channel_shapes.T, strict=True
    ):
        if frequency < 60.0:
            loudest = channels[int(np.argmax(np.abs(shape)))].name
            print(f'  {frequency:6.2f} Hz  {100 * damping:4.2f} %  most at {loudest}')

    rng = np.random.default_rng(1)
    shaking = rng.normal(scale=0.5, size=(5000, model.n_joints))
    reading = model.time_response(q, channels, shaking, sample_rate_hz=500.0).output
    print(f'shaken with 0.5 rad/s² rms: {reading.std(axis=0).max():.2f} m/s² rms at most')

    scan = model.scan(random_poses(model.limits, 500, rng), n_modes=3)
    low, high = scan.frequency_hz[:, 0].min(), scan.frequency_hz[:, 0].max()
    print(f'first mode over 500 poses: {low:.2f} to {high:.2f} Hz')

    payload = model.spec.masses[0].name
    heavier = model.with_parameters({f'masses.{payload}.mass_kg': 80.0})
    print(f'with 80 kg for {payload}: {heavier.modes(q).frequency_hz[:3].round(2)} Hz')


if __name__ == '__main__':
    main(*sys.argv[1:3])
