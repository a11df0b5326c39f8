"""Links chained by their places stand where the rigid kinematics put them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from structural_model import load_robot
from structural_model.rigid import FrameTree


@pytest.mark.parametrize('name', ['irb6660_205_190', 'generic_arm_6'])
def test_chained_places_are_those_of_the_kinematics(name):
    model = load_robot(name)
    tree, seed = FrameTree(model.robot), 4
    rng = np.random.default_rng(seed)
    for q in rng.uniform(-1.0, 1.0, (5, model.n_joints)):
        placed = {'base_link': (np.zeros(3), np.eye(3))}
        waiting = [*tree.moving(q), *tree.fixed()]
        while waiting:
            link = next(each for each in waiting if each.parent in placed)
            waiting.remove(link)
            origin, axes = placed[link.parent]
            turned = Rotation.from_quat(link.quaternion).as_matrix()
            placed[link.child] = (origin + axes @ link.position, axes @ turned)
        assert set(placed) == set(model.link_names)
        for link in (model.link_names[2], model.link_names[-1]):
            place = [0.1, 0.2, 0.3]
            expected = model.geometry.positions(q[None, :], [(link, np.array(place))])[0, 0]
            origin, axes = placed[link]
            np.testing.assert_allclose(
                origin + axes @ place, expected, atol=1e-9, err_msg=f'seed {seed}'
            )
