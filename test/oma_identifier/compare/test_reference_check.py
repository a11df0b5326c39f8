"""References that are wired otherwise in one set-up are named; those in order are not."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.errors import LayoutError
from oma_identifier.compare import check_references, shared_channels
from test.oma_identifier.compare.test_merging import drawn

SEEDS = range(4000, 4020)
CHANGES = {
    'turned': np.diag([1.0, -1.0, 1.0]),
    'exchanged': np.eye(3)[[1, 0, 2]],
    'times': np.diag([1.0, 9.8, 1.0]),
}


def set_ups(seed):
    rng = np.random.default_rng(seed)
    found, *_ = drawn(rng, int(rng.integers(3, 8)), seen=0.8, scatter=0.002)
    names = [f's{number}' for number in range(len(found))]
    return found, names, shared_channels([each.channel_names for each in found])


def test_references_in_order_are_never_refused():
    for seed in SEEDS:
        check_references(*set_ups(seed))


@pytest.mark.parametrize('what', CHANGES)
def test_a_reference_wired_otherwise_is_named_with_its_set_up(what):
    """Where the set-up shows five modes or more; fewer may tell nothing."""
    n_tried = n_right = 0
    for seed in SEEDS:
        setups, names, references = set_ups(seed)
        wrong = int(np.argmax([len(each) for each in setups]))
        if len(setups[wrong]) < 5:
            continue
        modes = []
        for mode in setups[wrong].modes:
            shape = mode.shape.copy()
            shape[:3] = CHANGES[what] @ shape[:3]
            modes.append(replace(mode, shape=shape, shape_std=None))
        setups[wrong] = replace(setups[wrong], modes=tuple(modes))
        n_tried += 1
        with pytest.raises(LayoutError, match=what) as caught:
            check_references(setups, names, references)
        n_right += str(caught.value).startswith(f's{wrong}:')
    print(f'seeds {SEEDS}: {n_right} of {n_tried} named')
    assert n_tried >= 8 and n_right >= 0.9 * n_tried
