"""CPU time of the structural model on one core: python benchmarks/structural_model_speed.py"""

import os

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import time

import numpy as np

from structural_model import load_layout, load_robot
from structural_model.scan import random_poses


def least_ms(task, count, repeats=7):
    """Return the least time of one of ``count`` units of work [ms]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        task()
        times.append(time.process_time() - start)
    return 1e3 * min(times) / count


for robot in ('generic_arm_6', 'irb6660_205_190'):
    model, channels = load_robot(robot), load_layout(robot).channels
    q = random_poses(model.limits, 500, np.random.default_rng(0))
    payload = f'masses.{model.spec.masses[0].name}.mass_kg'
    rows = {
        'modes at a pose': least_ms(lambda m=model, q=q: [m.modes(x) for x in q[:100]], 100),
        'modes with 42 channels': least_ms(
            lambda m=model, q=q, c=channels: [m.modes(x, c) for x in q[:100]], 100
        ),
        'scan, a pose': least_ms(lambda m=model, q=q: m.scan(q), 500, 3),
        'changed model': least_ms(
            lambda m=model, p=payload: m.with_parameters({p: 3.0}).assembly, 1
        ),
        'torque, a sample': least_ms(lambda m=model, q=q: m.torque(q, q, q), 500),
    }
    print(f'{robot}, {model.n_dof} degrees of freedom')
    for name, value in rows.items():
        print(f'  {name:24s} {value:8.4f} ms')
