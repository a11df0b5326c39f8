"""Records of unequal length are stepped together."""

import numpy as np

from model_gap.joint_law import CubicLaw
from model_gap.setup import JointForce
from model_gap.time_domain import JointPath, step_torques


def test_shorter_record_is_stepped_as_if_alone():
    rng = np.random.default_rng(3)

    def path(steps):
        twist = 1e-3 * rng.standard_normal(steps)
        return JointPath(
            poles=np.array([-3.0 + 60.0j]),
            residues=np.array([1e-7 - 2e-7j]),
            instant=1e-8,
            twist=twist,
            rate=np.gradient(twist),
            speed=np.zeros(steps),
            vector=np.ones(1),
            stiffness=1e6,
            static_twist=0.0,
        )

    force = JointForce('joint_2', CubicLaw, (1e6,))
    long, short = path(300), path(211)
    together = step_torques([long, short], [force, force])
    for torque, item in zip(together, (long, short), strict=True):
        (alone,) = step_torques([item], [force])
        assert len(torque) == len(item.twist)
        # The last value belongs to the step after the record.
        np.testing.assert_allclose(torque[:-1], alone[:-1], rtol=1e-12, atol=1e-9)
        assert np.abs(torque).max() > 0.1
