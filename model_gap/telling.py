"""What the recordings of a campaign can tell apart, asked before anything is found in them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from modal_core.work.progress import Progress
from model_gap.campaign import Campaign
from model_gap.decide import all_fitted, Telling, telling_apart
from model_gap.predict import compile_laws
from model_gap.quick_look import of_few
from model_gap.search import Search, SearchSettings
from structural_model import FlexibleJointModel


def what_it_tells(
    model: FlexibleJointModel,
    campaign: Campaign,
    poses: Sequence[NDArray[np.float64]] = (),
    settings: SearchSettings | None = None,
    progress: Progress = lambda _: None,
) -> Telling:
    """Return which effects a campaign would show and tell apart, were they there.

    Parameters
    ----------
    model : FlexibleJointModel
        As it is.
    campaign : Campaign
        Recordings of a few poses are enough; one is enough too.
    poses : sequence of (n_joints,) array [rad]
        Where its loudest motion could be repeated.
    settings : SearchSettings or None
        Band, tolerances, catalogue.
    progress : callable
        Takes the fraction done.
    """
    compile_laws()
    with threadpool_limits(limits=1, user_api='blas'):  # small matrices: threads only wait
        search = Search.begin(model, of_few(all_fitted(campaign)), settings)
        progress(0.1)
        found = telling_apart(search, poses)
    progress(1.0)
    return found
