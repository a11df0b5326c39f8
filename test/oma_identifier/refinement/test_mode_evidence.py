"""One mode or two: what the likelihood adds, drops and leaves."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.identifier.plant import Plant, simulate
from benchmarks.identifier.scatter import match
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.likelihood import shape_prior
from oma_identifier.motion.robot_signals import never
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.adopt import adopt_refined, Adopted, NEW
from oma_identifier.refinement.refinement import refine
from oma_identifier.selection.new_modes import NewModeTest, without_doubtful
from oma_identifier.settings import IdentificationSettings
from test.support.plant_modes import modes_of

RATE_HZ = 128.0
SEEDS = range(900, 908)


def pair_plant(generator: np.random.Generator) -> Plant:
    """Two modes 1 % apart that overlap wholly, and one on either side."""
    return Plant(
        frequency_hz=np.array([9.0, 20.0, 20.2, 36.0]),
        damping_ratio=np.array([0.02, 0.04, 0.03, 0.02]),
        shapes=generator.standard_normal((6, 4)),
        participation=generator.standard_normal((4, 4)),
    )


@pytest.fixture(scope='module')
def records() -> list[tuple[Plant, Samples]]:
    pairs = []
    for seed in SEEDS:
        generator = np.random.default_rng(seed)
        plant = pair_plant(generator)
        pairs.append((plant, simulate(plant, generator, 60.0, RATE_HZ)))
    return pairs


def test_the_second_of_two_modes_that_overlap_wholly_is_found(records):
    n_found = 0
    for plant, samples in records:
        found = adopt_refined(samples, modes_of(plant, samples, [0, 1, 3]), ModeSet((), ()))
        assert found.origin.count(NEW) <= 1, SEEDS
        values, left = match(found.modes, plant)
        n_found += bool(np.isfinite(values[0]).all()) and not left
    # The data of one or two in ten hardly determine the shapes of such a pair.
    assert n_found >= len(SEEDS) - 2, f'seeds {SEEDS}: {n_found}'


def test_nothing_is_added_to_a_complete_list_and_nothing_taken_away(records):
    for plant, samples in records:
        result = refine(samples, modes_of(plant, samples, [0, 1, 2, 3]))
        assert result.added == (), SEEDS
        assert Outcome.SUPERFLUOUS not in result.outcomes, SEEDS


def test_a_mode_far_from_all_listed_ones_is_found_by_its_flank(records):
    plant, samples = records[0]
    result = refine(samples, modes_of(plant, samples, [1, 2, 3]))
    near = [mode for mode in result.added if abs(mode.frequency_hz - 9.0) < 0.2]
    for mode in result.added:
        assert mode in near
        assert mac(mode.shape, plant.shapes[:, 0])[0, 0] > 0.98


def test_a_mode_listed_twice_is_dropped_once(records):
    plant, samples = records[0]
    once = modes_of(plant, samples, [0, 1, 2, 3])
    again = replace(once.modes[0], frequency_hz=9.1, damping_ratio=0.03)
    twice = replace(once, modes=(once.modes[0], again, *once.modes[1:]))
    found = adopt_refined(samples, twice, ModeSet((), ()))
    assert len(found.modes) == 4
    assert set(found.origin) in ({0, 2, 3, 4}, {1, 2, 3, 4})
    assert found.modes.modes[0].frequency_hz == pytest.approx(9.0, abs=0.15)


def test_a_new_mode_outside_the_analysed_band_or_on_a_line_is_not_reported(records):
    plant, samples = records[0]
    mode = modes_of(plant, samples, [1]).modes[0]
    sharp = replace(mode, damping_ratio=0.004)
    line = ModeSet((Mode(20.01, 0.0, mode.shape, harmonic=True),), samples.channel_names)
    none = ModeSet((), samples.channel_names)
    settings = IdentificationSettings()
    below = IdentificationSettings(max_frequency_hz=15.0)

    def kept(mode, settings, lines):
        adopted = Adopted(ModeSet((mode,), samples.channel_names), (NEW,))
        return len(without_doubtful(adopted, NewModeTest(samples, settings, lines, never)).modes)

    assert kept(mode, settings, none) == 1
    assert kept(mode, settings, line) == 1
    assert kept(mode, below, none) == 0
    assert kept(sharp, settings, line) == 0
    found = Adopted(ModeSet((mode,), samples.channel_names), (0,))
    assert without_doubtful(found, NewModeTest(samples, below, line, never)) is found


def test_poles_name_their_modes_when_the_list_has_changed():
    """A structure whose pair the subspace method takes for one mode."""
    plant = pair_plant(np.random.default_rng(3098))
    plant = replace(plant, frequency_hz=np.array([9.0, 20.0, 20.1, 36.0]))
    n_new = 0
    for seed in range(20, 28):
        samples = simulate(plant, np.random.default_rng(seed), 40.0, RATE_HZ)
        plain = identify_samples(samples, IdentificationSettings(refine=False))
        result = identify_samples(samples)
        n_new += len(result.modes) > len(plain.modes)
        for number, mode in enumerate(result.modes, start=1):
            own = result.poles.frequency_hz[result.poles.mode_id == number]
            assert len(own) == 0 or np.median(own) == pytest.approx(mode.frequency_hz, rel=0.03)
    assert n_new > 0, 'seeds 20..27'


def test_gradient_of_the_prior_of_shapes_is_the_slope_of_its_penalty():
    generator = np.random.default_rng(0)
    shape = generator.standard_normal(5) + 0.3j * generator.standard_normal(5)
    shape /= np.linalg.norm(shape)
    across = np.linalg.svd(shape[:, None])[0][:, 1:]
    step = 1e-6

    def penalty(move):
        moved = shape + move
        return shape_prior.penalty(moved / np.linalg.norm(moved))

    slopes = [
        (penalty(-step * part * direction) - penalty(step * part * direction)) / (2.0 * step)
        for direction in across.T
        for part in (1.0, 1.0j)
    ]
    found = shape_prior.gradient(shape[:, None], across[None])
    np.testing.assert_allclose(found, [slopes], rtol=1e-5)
    assert shape_prior.penalty(np.exp(0.7j) * np.abs(shape)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('seed', range(6))
def test_a_second_view_of_a_mode_is_left_out_however_far_beside_it(seed):
    """Some half-widths away it overlaps with nothing; a mode of the same shape there stays."""
    generator = np.random.default_rng(seed)
    hz, away = 20.0, generator.uniform(5.0, 12.0) * generator.choice([-1.0, 1.0])
    shapes = generator.standard_normal((4, 3))
    plant = Plant(
        np.array([9.0, hz, 21.5]),
        np.array([0.006, 0.002, 0.004]),
        shapes,
        generator.standard_normal((3, 3)),
    )
    alike = Mode(
        hz * (1.0 + 0.002 * away),
        0.004,
        (shapes[:, 1] + 0.1 * generator.standard_normal(4)).astype(complex),
        0.02,
        0.001,
    )
    both = Plant(
        np.append(plant.frequency_hz, alike.frequency_hz),
        np.append(plant.damping_ratio, alike.damping_ratio),
        np.column_stack([shapes, alike.shape.real]),
        generator.standard_normal((4, 4)),
    )
    for true, n_left in ((plant, 3), (both, 4)):
        samples = simulate(true, generator, 100.0, 64.0)
        given = modes_of(plant, samples, [0, 1, 2])
        given = replace(given, modes=(*given.modes, alike))
        found = adopt_refined(samples, given, ModeSet((), ()))
        assert len(found.modes) == n_left, f'seed {seed}: {found.origin}'
