"""The regression against what can be computed by hand, and its gradients."""

from dataclasses import replace

import numpy as np
import pytest

from workspace_map.regression import (
    covariance,
    evidence_of,
    likeness,
    most_probable_scales,
    posterior,
    Rows,
    Scales,
    Shared,
)

SEED = 7
SCALES = Scales(np.array([0.2, 1.0]), np.array([0.5, 0.0]), np.array([0.05, 0.1]), np.ones(3))


def drawn_rows(n_rows, rng, n_poses=9):
    return Rows(
        (rng.standard_normal((n_rows, 4)), rng.standard_normal((n_rows, 2))),
        rng.uniform(-np.pi, np.pi, (n_poses, 3)),
        rng.integers(0, n_poses, n_rows),
        rng.integers(0, 2, n_rows),
    )


def test_a_full_turn_of_a_joint_changes_nothing():
    q = np.random.default_rng(SEED).uniform(-3.0, 3.0, (5, 3))
    turned = q + 2.0 * np.pi * np.array([1.0, -1.0, 2.0])
    assert np.diag(likeness(q, turned, np.ones(3))) == pytest.approx(1.0)


def test_posterior_is_that_of_the_joint_normal_distribution():
    rng = np.random.default_rng(SEED)
    measured, asked = drawn_rows(20, rng), drawn_rows(6, rng)
    residual, std = rng.standard_normal(20), np.full(20, 0.1)
    found = posterior(measured, residual, std, SCALES)
    noise = np.diag(std**2 + SCALES.white[measured.kind] ** 2)
    whole = np.linalg.inv(covariance(measured, measured, SCALES) + noise)
    cross = covariance(measured, asked, SCALES)
    expected = covariance(asked, asked, SCALES) - cross.T @ whole @ cross
    assert found.covariance(asked, asked) == pytest.approx(expected, abs=1e-10)
    for row in range(6):
        at = found.functions(asked.q[asked.pose[row]])
        mean = sum(part[row] @ own for part, own in zip(asked.parts, at, strict=True))
        assert mean == pytest.approx(cross[:, row] @ whole @ residual)


def test_an_arm_after_another_is_one_regression_on_both():
    """Functions of the second are those of the first and a difference, which has its own scales.

    Against the joint normal distribution of all rows of both; the first knows its functions no
    better than it measured them.
    """
    rng = np.random.default_rng(SEED)
    first, second, asked = (drawn_rows(n, rng) for n in (15, 10, 5))
    apart = Scales(np.array([0.1, 0.3]), np.array([0.05, 0.0]), SCALES.white, np.full(3, 2.0))
    off, std = rng.standard_normal(25), np.full(25, 0.1)
    one = posterior(first, off[:15], std[:15], SCALES)

    def mean(rows):
        at = [one.functions(q) for q in rows.q]
        each = zip(range(len(rows)), rows.pose, strict=True)
        return np.array(
            [sum(p[r] @ f for p, f in zip(rows.parts, at[k], strict=True)) for r, k in each]
        )

    two = posterior(second, off[15:] - mean(second), std[15:], apart, one)

    def shared(a, b, both_second):
        return covariance(a, b, SCALES) + (covariance(a, b, apart) if both_second else 0.0)

    noise = np.concatenate([SCALES.white[first.kind], apart.white[second.kind]]) ** 2 + std**2
    whole = np.block(
        [
            [shared(first, first, False), shared(first, second, False)],
            [shared(second, first, False), shared(second, second, True)],
        ]
    ) + np.diag(noise)
    cross = np.vstack([shared(first, asked, False), shared(second, asked, True)])
    left = shared(asked, asked, True) - cross.T @ np.linalg.solve(whole, cross)
    assert two.covariance(asked, asked) == pytest.approx(left, abs=1e-9)
    expected = cross.T @ np.linalg.solve(whole, off)
    for row in range(5):
        q = asked.q[asked.pose[row]]
        found = [a + b for a, b in zip(one.functions(q), two.functions(q), strict=True)]
        value = sum(part[row] @ own for part, own in zip(asked.parts, found, strict=True))
        assert value == pytest.approx(expected[row], abs=1e-9)


def test_parts_of_its_own_are_neither_known_nor_taken_from_the_other_arm():
    """The second part is each arm's own: against the normal distribution of all rows of both."""
    rng = np.random.default_rng(SEED)
    first, second, asked = (drawn_rows(n, rng) for n in (15, 10, 5))
    off, std = rng.standard_normal(25), np.full(25, 0.1)
    one = posterior(first, off[:15], std[:15], SCALES)
    common = replace(SCALES, constant=np.array([SCALES.constant[0], 0.0]))

    def of_first(q):
        return one.functions(q)[0]

    mean = [
        first_part @ of_first(second.q[p])
        for first_part, p in zip(second.parts[0], second.pose, strict=True)
    ]
    two = posterior(second, off[15:] - mean, std[15:], SCALES, Shared(one, (1,)))
    noise = np.concatenate([SCALES.white[each.kind] for each in (first, second)]) ** 2 + std**2
    whole = np.block(
        [
            [covariance(first, first, SCALES), covariance(first, second, common)],
            [
                covariance(second, first, common),
                covariance(second, second, common) + covariance(second, second, SCALES),
            ],
        ]
    ) + np.diag(noise)
    cross = np.vstack(
        [
            covariance(first, asked, common),
            covariance(second, asked, common) + covariance(second, asked, SCALES),
        ]
    )
    prior = covariance(asked, asked, common) + covariance(asked, asked, SCALES)
    left = prior - cross.T @ np.linalg.solve(whole, cross)
    assert two.covariance(asked, asked) == pytest.approx(left, abs=1e-9)
    expected = cross.T @ np.linalg.solve(whole, off)
    for row in range(5):
        q = asked.q[asked.pose[row]]
        shared, own = two.functions(q)
        value = asked.parts[0][row] @ (of_first(q) + shared) + asked.parts[1][row] @ own
        assert value == pytest.approx(expected[row], abs=1e-9)


@pytest.mark.parametrize('known', [0.0, 0.3])
def test_gradient_of_the_evidence_is_its_slope(known):
    rng = np.random.default_rng(SEED)
    root = known * rng.standard_normal((30, 30))
    found = evidence_of(
        drawn_rows(30, rng),
        rng.standard_normal(30),
        np.full(30, 0.1),
        SCALES,
        1.0,
        root @ root.T,
    )
    at = SCALES.logs() + 0.3 * rng.standard_normal(len(SCALES.logs()))
    steps = 1e-5 * np.eye(len(at))
    slopes = [(found.at(at + step)[0] - found.at(at - step)[0]) / 2e-5 for step in steps]
    assert found.at(at)[1] == pytest.approx(slopes, rel=1e-5, abs=1e-5)


def test_scales_that_made_the_data_are_found():
    """Seed 7: a function three times as large as expected, from 250 rows at 120 poses."""
    rng = np.random.default_rng(SEED)
    rows = drawn_rows(250, rng, 120)
    true = Scales(np.array([0.2, 1.0]), np.array([1.5, 0.0]), SCALES.white, SCALES.length)
    noise = np.full(250, 0.05)
    whole = covariance(rows, rows, true) + np.diag(noise**2 + true.white[rows.kind] ** 2)
    residual = np.linalg.cholesky(whole) @ rng.standard_normal(250)
    found = most_probable_scales(evidence_of(rows, residual, noise, SCALES, 1.0), SCALES)
    assert found.varying[0] == pytest.approx(1.5, rel=0.5)
    assert found.varying[1] == 0.0
