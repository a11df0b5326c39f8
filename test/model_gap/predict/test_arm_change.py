"""Forces that changes of an arm are: of many at once those of each alone."""

import numpy as np
import pytest

from model_gap.predict import ArmChange, forces, parts

DOF, MOVING, BINS = 4, 16, 9


@pytest.fixture
def motion(rng):
    return (rng.standard_normal((MOVING, BINS, 2)) @ [1.0, 1j]).astype(np.complex64)


def test_forces_of_many_changes_are_those_of_each(motion, rng):
    changes = [ArmChange(rng.standard_normal((DOF, MOVING))) for _ in range(3)]
    found = forces(parts(motion), changes)
    for number, change in enumerate(changes):
        np.testing.assert_allclose(found[:, :, number].T, change.matrix @ motion, rtol=1e-4)


def test_no_change_is_no_force(motion):
    found = forces(parts(motion), [ArmChange(np.zeros((DOF, MOVING)))])
    assert found.shape == (BINS, DOF, 1)
    assert not found.any()
