"""An arm that a counterbalance pulls far aside: where it hangs depends on springs and masses."""

from dataclasses import replace

import numpy as np

from model_gap.effects.gravity_compensator import GravityCompensator
from model_gap.fit.linearise import effect_columns, tolerance_columns
from model_gap.search import Search
from test.support.planar_arm import planar_arm
from test.support.shaken_once import shaken_once

SEED = 62
STEP = 0.01


def test_derivatives_count_where_the_arm_hangs(tmp_path):
    arm = planar_arm(tmp_path / 'arm')
    damping = replace(arm.spec.damping, stiffness_proportional_s=2e-3)
    model = replace(arm, spec=replace(arm.spec, damping=damping))
    search = Search.begin(model, shaken_once(model, SEED, until_s=4.0))
    strength = 0.4 * model.spec.joints[1].drive.spring.stiffness
    balance = GravityCompensator(model.joint_names[1])
    pulled = search.nominal.with_effect(balance, (0.0, strength))
    predictor = search.data.fitting
    arms = predictor.arms(pulled.cell().spec)
    assert max(np.abs(arm.rest).max() for arm in arms) > 0.1

    def rows(number, step):
        steps = np.zeros(len(columns))
        steps[number] = step
        return predictor.rows(pulled.stepped(steps).cell()).astype(float)

    base = predictor.rows(pulled.cell())
    columns = np.concatenate(
        [tolerance_columns(pulled, predictor), effect_columns(pulled, predictor, base)]
    ).astype(float)
    names = [item.name for item in pulled.tolerances]
    for number in (names.index('stiffness of j2'), names.index('mass of l3'), len(names)):
        exact = (rows(number, STEP) - rows(number, -STEP)) / (2.0 * STEP)
        error = np.linalg.norm(columns[number] - exact) / np.linalg.norm(exact)
        assert error < 0.01, (SEED, number, error)
