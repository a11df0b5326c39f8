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


def reshaped(setup, change):
    """Return a set-up with changed shapes, of which nobody knows how sure they are."""
    modes = [replace(each, shape=change(each.shape), shape_std=None) for each in setup.modes]
    return replace(setup, modes=tuple(modes))


def test_references_in_order_are_never_refused():
    for seed in SEEDS:
        assert check_references(*set_ups(seed)) is None


@pytest.mark.parametrize('what', CHANGES)
def test_a_reference_wired_otherwise_is_named_with_its_set_up(what):
    """Where the set-up shows five modes or more; fewer may tell nothing."""
    n_tried = n_right = 0
    for seed in SEEDS:
        setups, names, references = set_ups(seed)
        wrong = int(np.argmax([len(each) for each in setups]))
        if len(setups[wrong]) < 5:
            continue
        setups[wrong] = reshaped(
            setups[wrong], lambda shape: np.append(CHANGES[what] @ shape[:3], shape[3:])
        )
        n_tried += 1
        with pytest.raises(LayoutError, match=what) as caught:
            check_references(setups, names, references)
        n_right += str(caught.value).startswith(f's{wrong}:')
    print(f'seeds {SEEDS}: {n_right} of {n_tried} named')
    assert n_tried >= 8 and n_right >= 0.9 * n_tried


def dead(rng, shape):
    """What noise alone leaves of a sensor: small, with any phase."""
    return 1e-3 * np.abs(shape).max() * (rng.normal() + 1j * rng.normal())


def moved(rng, shape):
    """A sensor that stands elsewhere: of another size and sign in each mode."""
    return 0.7 * np.abs(shape).max() * rng.normal()


@pytest.mark.parametrize('what', [dead, moved])
def test_a_reference_that_is_dead_or_elsewhere_is_left_out_of_its_set_up(what):
    """No change of it mends that; its modes had stood beside those of the others."""
    n_tried = n_right = n_wrong = 0
    for seed in SEEDS:
        setups, names, references = set_ups(seed)
        rng = np.random.default_rng([seed, 1])
        wrong = int(np.argmax([len(each) for each in setups]))
        if len(setups[wrong]) < 5:
            continue
        setups[wrong] = reshaped(
            setups[wrong],
            lambda shape, rng=rng: np.array([shape[0], what(rng, shape), *shape[2:]]),
        )
        n_tried += 1
        try:
            told = check_references(setups, names, references)
        except LayoutError as refused:  # Half of the modes may fit by a gain.
            told = wrong if str(refused).startswith(f's{wrong}:') else -1, references[1]
        n_right += told == (wrong, references[1])
        n_wrong += told not in (None, (wrong, references[1]))
    print(f'seeds {SEEDS}: {n_right} of {n_tried} told, {n_wrong} wrongly')
    assert n_tried >= 8 and n_right >= 0.8 * n_tried and n_wrong == 0
