"""CPU time of the structural model on one core: python -m benchmarks.structural_model_speed"""

import os

os.environ['OPENBLAS_NUM_THREADS'] = '1'

import time

import numpy as np

from benchmarks.results import write_rows
from structural_model import load_layout, load_robot
from structural_model.equations import random_poses

ROBOTS = ('generic_arm_6', 'irb6660_205_190')


def least_ms(task, count, repeats=7):
    """Return the least time of one of ``count`` units of work [ms]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        task()
        times.append(time.process_time() - start)
    return 1e3 * min(times) / count


def measured(model, channels):
    """Return what takes how long [ms]."""
    q = random_poses(model.limits, 500, np.random.default_rng(0))
    payload = f'masses.{model.spec.masses[0].name}.mass_kg'
    return {
        'modes at a pose': least_ms(lambda: [model.modes(x) for x in q[:100]], 100),
        'modes with 42 channels': least_ms(
            lambda: [model.modes(x, channels) for x in q[:100]], 100
        ),
        'workspace scan, a pose': least_ms(lambda: model.scan(q), 500, 3),
        'changed model': least_ms(lambda: model.with_parameters({payload: 3.0}).assembly, 1),
        'torque, a sample': least_ms(lambda: model.torque(q, q, q), 500),
    }


def main():
    models = [load_robot(robot) for robot in ROBOTS]
    times = [
        measured(model, load_layout(robot).channels)
        for model, robot in zip(models, ROBOTS, strict=True)
    ]
    columns = [
        'what',
        *(
            f'{robot}, {model.n_dof} degrees of freedom [ms]'
            for model, robot in zip(models, ROBOTS, strict=True)
        ),
    ]
    rows = [[name, *(f'{each[name]:.3g}' for each in times)] for name in times[0]]
    for row in (columns, *rows):
        print(' | '.join(row))
    write_rows('model_speed', columns, rows, ('CPU time of one core',))


if __name__ == '__main__':
    main()
