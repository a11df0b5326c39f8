"""The automatic identification against known truth and published results."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from benchmarks.identifier.plant import Plant, simulate
from modal_core.channel import Channel
from modal_core.errors import IdentificationError
from modal_core.numbers.indicators import mac
from modal_core.poles import PoleStatus
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.result import NO_MODE
from oma_identifier.settings import IdentificationSettings

FREQUENCY_HZ = (2.1, 7.3, 9.9, 24.0, 24.4, 61.0, 90.0)
DAMPING_RATIO = (0.02, 0.04, 0.015, 0.012, 0.014, 0.02, 0.055)


def named(array, rate_hz):
    names = tuple(Channel(name=f'c{column}') for column in range(array.shape[1]))
    return Samples(array, rate_hz, names)


@pytest.mark.parametrize('seed', range(3))
def test_finds_every_mode_and_no_other(structure, seed):
    known = structure(FREQUENCY_HZ, DAMPING_RATIO, n_channels=8, seed=seed)
    result = identify_samples(known.simulate(np.random.default_rng(100 + seed), 120.0, 256.0))
    modes = result.modes
    assert len(modes) == len(FREQUENCY_HZ), f'seed {seed}: {modes.frequency_hz}'
    for mode, hz, zeta, shape in zip(
        modes, FREQUENCY_HZ, DAMPING_RATIO, known.shapes.T, strict=True
    ):
        assert abs(mode.frequency_hz - hz) < 4.0 * mode.frequency_std_hz, (seed, hz)
        assert abs(mode.damping_ratio - zeta) < 4.0 * mode.damping_ratio_std, (seed, hz)
        assert mode.frequency_std_hz < 0.02 * hz
        assert mac(mode.shape, shape)[0, 0] > 0.95, (seed, hz)


def test_poles_of_the_diagram_name_their_modes(structure):
    known = structure((5.0, 12.0), (0.02, 0.02))
    result = identify_samples(known.simulate(np.random.default_rng(1), 60.0, 64.0))
    assert len(result.modes) == 2
    for number, mode in enumerate(result.modes, start=1):
        own = result.poles.mode_id == number
        assert np.all(result.poles.status[own] == PoleStatus.KEPT)
        assert np.median(result.poles.frequency_hz[own]) == pytest.approx(
            mode.frequency_hz, rel=0.01
        )
    assert np.all(result.poles.mode_id[result.poles.status != PoleStatus.KEPT] == 0)


def test_order_and_gain_of_channels_do_not_matter(structure):
    samples = structure((5.0, 12.0, 12.4), (0.02, 0.02, 0.01)).simulate(
        np.random.default_rng(2), 60.0, 64.0
    )
    plain = identify_samples(samples)
    gain = np.array([1.0, 30.0, 0.01, 5.0, 2.0, 1.0])
    turned = identify_samples(named((samples.acceleration * gain)[:, ::-1], 64.0))
    assert len(plain.modes) == 3
    # Round-off of another order of summation, carried through the Gram matrix and eigenvalues.
    for mode, other in zip(plain.modes, turned.modes, strict=True):
        assert abs(mode.frequency_hz - other.frequency_hz) < 1e-4 * mode.frequency_std_hz
        assert abs(mode.damping_ratio - other.damping_ratio) < 1e-4 * mode.damping_ratio_std


@pytest.mark.parametrize('n_channels', [1, 6])
def test_white_noise_has_no_mode_and_says_so(n_channels):
    rng = np.random.default_rng(3)
    result = identify_samples(named(rng.standard_normal((15000, n_channels)), 250.0))
    assert len(result.modes) == 0
    assert not result.quality.identifiable
    assert result.quality.reason == NO_MODE


@pytest.mark.parametrize('n_channels', [3, 6])
def test_edge_of_an_anti_aliasing_filter_is_no_mode(n_channels):
    edge = butter(6, 0.8, output='sos')
    for seed in range(9000, 9004):
        rng = np.random.default_rng(seed)
        noise = sosfilt(edge, rng.standard_normal((15000, n_channels)), axis=0)
        mixed = (noise + 0.002 * rng.standard_normal(noise.shape)) @ rng.standard_normal(
            (n_channels, n_channels)
        )
        modes = identify_samples(named(mixed, 250.0), IdentificationSettings(refine=False)).modes
        assert len(modes) == 0, f'seed {seed}: {modes.frequency_hz}'


def test_low_modes_of_a_short_and_slow_record_are_found(structure):
    known = structure((1.3, 3.1, 5.9), (0.03, 0.02, 0.015), n_channels=3)
    for seed in range(8, 12):
        modes = identify_samples(known.simulate(np.random.default_rng(seed), 60.0, 20.0)).modes
        np.testing.assert_allclose(
            modes.frequency_hz[:2], [1.3, 3.1], rtol=0.03, err_msg=f'seed {seed}'
        )


def test_a_mode_near_half_the_rate_is_found(structure):
    known = structure((30.0, 84.0), (0.02, 0.015))
    modes = identify_samples(known.simulate(np.random.default_rng(7), 60.0, 200.0)).modes
    np.testing.assert_allclose(modes.frequency_hz, [30.0, 84.0], rtol=0.01)


def test_pure_sines_are_harmonics_not_modes():
    rng = np.random.default_rng(4)
    time = np.arange(30000) / 500.0
    sines = np.sin(2 * np.pi * 23.3 * time) + 0.4 * np.sin(2 * np.pi * 46.6 * time + 1.0)
    data = sines[:, None] * np.array([1.0, 0.5, -0.7]) + 0.1 * rng.standard_normal((30000, 3))
    result = identify_samples(named(data, 500.0))
    assert len(result.modes) == 0
    np.testing.assert_allclose(result.harmonics.frequency_hz, [23.3, 46.6], rtol=1e-3)
    assert all(line.harmonic for line in result.harmonics)


def test_gravity_and_drift_are_no_modes(structure):
    samples = structure((6.0, 17.0), (0.02, 0.03)).simulate(np.random.default_rng(5), 60.0, 100.0)
    time = np.arange(len(samples.acceleration)) / 100.0
    drift = 9.81 + 0.2 * time + 3.0 * np.sin(2 * np.pi * time / 60.0)
    result = identify_samples(named(samples.acceleration + drift[:, None], 100.0))
    np.testing.assert_allclose(result.modes.frequency_hz, [6.0, 17.0], rtol=0.01)


@pytest.mark.parametrize(
    ('array', 'says'),
    [
        (np.zeros((1000, 2)), 'no channel moves'),
        (np.full((1000, 2), 9.81), 'no channel moves'),
        (np.full((1000, 2), np.nan), 'c0'),
        (np.random.default_rng(6).standard_normal((40, 2)), 'too short'),
    ],
)
def test_what_cannot_be_identified_says_why(array, says):
    with pytest.raises(IdentificationError) as caught:
        identify_samples(named(array, 100.0))
    assert says in str(caught.value)


@pytest.mark.parametrize('max_frequency_hz', [None, 10.0, 7.0, 5.0])
@pytest.mark.slow
def test_clt_building(data_path, max_frequency_hz):
    # Aloisio, Pasca, Tomasi, Fragiacomo (2020), Engineering Structures 213, 110593
    data = np.load(data_path('palisaden_clt_building', 'Palisaden_dataset.npy'))
    settings = IdentificationSettings(
        max_frequency_hz=max_frequency_hz, refine=max_frequency_hz == 5.0
    )
    result = identify_samples(named(data, 100.0), settings)
    low = result.modes.frequency_hz[result.modes.frequency_hz < 3.2]
    np.testing.assert_allclose(low, [1.88, 2.42, 2.69], rtol=0.005)


def test_smartphone_on_a_slab(data_path):
    # CESSIPy's example: Welch peak at 17.85 Hz, broad
    path = data_path('cessipy_slab_smartphone', 'Example02_Smartphone_Data.csv')
    table = np.genfromtxt(path, delimiter=',', skip_header=1)[:, :4]
    time = table[:, 0]
    rate_hz = (len(time) - 1) / (time[-1] - time[0])
    grid = time[0] + np.arange(len(time)) / rate_hz
    data = np.column_stack([np.interp(grid, time, column) for column in table[:, 1:].T])
    modes = identify_samples(named(data, rate_hz)).modes
    # The spectrum has a second peak, 10 dB high and broad, near 57 Hz; the example stops before.
    low = modes.frequency_hz[modes.frequency_hz < 40.0]
    np.testing.assert_allclose(low, [17.85], rtol=0.03)


@pytest.mark.parametrize('setup', [1, 2, 3])
def test_simulated_building_with_close_pairs(data_path, setup):
    truth = [2.63186, 2.69173, 3.43042, 8.29742, 8.42882, 10.6272, 14.0053, 14.093, 17.5741]
    data = np.load(data_path('pyoma2_3SL_simulated', f'set{setup}.npy'))
    settings = IdentificationSettings(refine=setup == 1)
    result = identify_samples(named(data, 100.0), settings)
    np.testing.assert_allclose(result.modes.frequency_hz, truth, rtol=0.01)


@pytest.fixture
def disturbed(structure):
    """Three modes, and a function that gives them back disturbed."""
    known = structure((6.0, 14.0, 27.0), (0.02, 0.015, 0.03))
    samples = known.simulate(np.random.default_rng(60), 90.0, 100.0)
    time = np.arange(len(samples.acceleration)) / 100.0

    def found(change):
        return identify_samples(named(change(samples.acceleration, time), 100.0))

    return found


def sine(data, phase):
    return data + 0.5 * data.std(axis=0) * np.sin(2 * np.pi * phase)[:, None]


@pytest.mark.parametrize(
    'change',
    [
        lambda data, time: sine(data, 10.0 * time),
        lambda data, time: sine(data, 14.0 * time),
        lambda data, time: sine(data, 18.0 * time + 0.03 * time**2),
        lambda data, time: sine(data, 20.0 * time + 0.2 * np.sin(1.2 * time)),
        lambda data, time: data * (1.0 + 3.0 * (np.sin(0.9 * time) > 0.8))[:, None],
        lambda data, time: np.clip(data, -1.5 * data.std(axis=0), 1.5 * data.std(axis=0)),
        lambda data, time: data * np.array([1.0, 1.0, 0.0, 1.0, 1.0, 1.0]),
    ],
    ids=['line', 'line on a mode', 'sweep', 'wavering line', 'bursts', 'clipped', 'dead channel'],
)
def test_disturbances_make_no_mode_and_hide_none(disturbed, change):
    np.testing.assert_allclose(disturbed(change).modes.frequency_hz, [6.0, 14.0, 27.0], rtol=0.015)


@pytest.mark.parametrize('line_hz', [10.0, 14.0])
def test_a_line_is_reported_as_one(disturbed, line_hz):
    result = disturbed(lambda data, time: sine(data, line_hz * time))
    np.testing.assert_allclose(result.harmonics.frequency_hz, [line_hz], rtol=1e-3)
    assert np.any(result.poles.status == PoleStatus.HARMONIC)


def test_a_mode_that_may_be_a_line_leaves_no_modes_behind_where_it_was_taken_out():
    """Its bell is narrower than a spectral line: what is no line for sure stays in the samples."""
    n_doubtful = 0
    for seed in (1, 6, 12, 15):
        generator = np.random.default_rng(seed)
        plant = Plant(
            np.array([4.7, 5.05, 5.37]) * (1.0 + 0.02 * generator.standard_normal(3)),
            np.array([0.002, 0.0025, 0.0003]),
            generator.standard_normal((4, 3)),
            np.diag([1.0, 1.0, 3.0]) * generator.uniform(0.5, 1.0, 3),
        )
        result = identify_samples(simulate(plant, generator, 60.0, 25.0))
        n_doubtful += 'line_or_mode' in result.quality.flags
        away = np.abs(result.modes.frequency_hz[:, None] - plant.frequency_hz).min(axis=1)
        assert np.all(away < 0.05), f'seed {seed}: {result.modes.frequency_hz}'
    assert n_doubtful > 0


@pytest.mark.parametrize('seed', [8, 14, 21])
def test_a_mode_beside_a_line_is_no_image_of_it(seed):
    """Two to five half-widths beside it, and many spectral lines: both are found."""
    generator = np.random.default_rng(seed)
    n_modes = 5
    hz = np.sort(np.exp(generator.uniform(*np.log((4.0, 45.0)), n_modes)))
    damping = np.exp(generator.uniform(*np.log((0.001, 0.01)), n_modes))
    shapes, forces = generator.standard_normal((6, n_modes)), generator.standard_normal((5, 5))
    beside = generator.integers(n_modes)
    away = generator.choice([-1, 1]) * np.exp(generator.uniform(*np.log((1.0, 8.0))))
    line_hz = float(hz[beside] * (1.0 + away * damping[beside]))
    line = (line_hz, float(np.exp(generator.uniform(*np.log((0.01, 0.3))))))
    plant = Plant(hz, damping, shapes, forces)
    samples = simulate(
        plant,
        generator,
        float(generator.choice([120, 300])),
        128.0,
        lines=(line,),
        simulation_rate_hz=1024.0,
    )
    result = identify_samples(samples)
    assert np.abs(result.harmonics.frequency_hz - line_hz).min() < 2.0 / samples.duration_s
    found = np.abs(result.modes.frequency_hz - hz[beside])
    assert found.min() < damping[beside] * hz[beside], f'seed {seed}: {result.modes.frequency_hz}'
