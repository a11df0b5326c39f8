"""The paper's findings on short settings: real computations, what the page on it claims."""

import sys

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def examples_importable(monkeypatch, request):
    monkeypatch.syspath_prepend(str(request.config.rootpath))
    yield
    for name in [name for name in sys.modules if name.split('.')[0] == 'examples']:
        del sys.modules[name]


def test_more_pulses_more_energy_and_a_first_notch_at_the_inverse_width():
    from examples.paper import pulse_spectrum

    one, eight, many = pulse_spectrum.densities(n_runs=60)
    assert [round(each.energy, 6) for each in (one, eight, many)] == [0.003, 0.024, 0.066]
    assert eight.mean_between(10, 200) / one.mean_between(10, 200) == pytest.approx(8, rel=0.1)
    assert many.mean_between(10, 200) / one.mean_between(10, 200) == pytest.approx(22, rel=0.1)
    for each in (one, eight, many):
        assert each.notch_hz == pytest.approx(1000 / 3, abs=1.0)


def test_theory_of_one_pulse_is_its_spectrum():
    from examples.paper import pulse_spectrum

    one = pulse_spectrum.densities(n_runs=400)[0]
    inside = (one.frequency_hz > 5.0) & (one.frequency_hz < 300.0)
    ratio = one.density[inside] / one.expected[inside]
    # A Hann window weighs the place of the pulse, not its spectrum: one factor for all.
    assert np.median(ratio) == pytest.approx(1.0, abs=0.15), 'seed 2025'
    assert np.ptp(ratio) < 0.05, 'seed 2025'


def test_drives_leave_little_of_the_planned_pulses_above_their_bandwidth():
    from examples.paper import pulse_spectrum

    real = pulse_spectrum.real_pulses(2.0, duration_s=20.0)
    low, high = np.array([5.0]), np.array([50.0])
    kept = [
        float(np.mean(real.driven.at(hz)) / np.mean(real.planned.at(hz))) for hz in (low, high)
    ]
    # Second order, 25 Hz: 1/((1 - r²)² + (2ζr)²) with ζ = 0.7 is 1.0 at 5 Hz and 0.059 at 50 Hz.
    assert kept[0] == pytest.approx(1.0, abs=0.15)
    assert kept[1] == pytest.approx(0.059, rel=0.25)


def test_sensitivity_prediction_is_exact_for_small_steps_and_wrong_for_wide_ones():
    from examples.paper import sensitivity

    regions = [sensitivity.region(sensitivity.robot(), pose) for pose in sensitivity.REGIONS]
    for each in regions:
        error = np.abs(each.predicted - each.actual)
        assert np.max(error[each.at(1.0)]) < 0.001, each.pose
        assert np.max(error[each.at(15.0)]) > 0.02, each.pose
        assert each.order_kept, each.pose


def test_largest_shape_does_not_name_the_most_sensitive_region():
    from examples.paper import sensitivity

    regions = [sensitivity.region(sensitivity.robot(), pose) for pose in sensitivity.REGIONS]
    actual = [each.actual[each.at(5.0)][:4] for each in regions]
    by_mass = [each.predicted[each.at(5.0)][:4] for each in regions]
    by_size = [each.by_size[:4] for each in regions]
    named = sensitivity.most_sensitive(actual)
    assert named == sensitivity.most_sensitive(by_mass) == ['P1', 'P2', 'P1', 'P1']
    agree = sum(a == b for a, b in zip(named, sensitivity.most_sensitive(by_size), strict=True))
    assert agree == 1


def test_the_cell_plays_the_plan_from_rest():
    from examples.paper import cell

    model = cell.robot()
    plan = cell.plan_pulses(model, 'P3', 0.0, 5.0, 3, 10.0)
    record = cell.shake(model, plan, 3, noise_density=0.0)
    assert record.position[0] == pytest.approx(plan.start_position, abs=1e-5)
    span_deg = np.rad2deg(np.ptp(model.to_controller(record.position), axis=0))
    planned_deg = np.rad2deg(np.ptp(model.to_controller(plan.position), axis=0))
    # Drives overshoot their command by a few percent.
    assert span_deg == pytest.approx(planned_deg, rel=0.08)
    assert len(record.acceleration) / cell.SAMPLE_RATE_HZ == pytest.approx(10.0, abs=0.1)
    # The drives' dead time of 20 ms is ten samples: until then the arm hangs in its own weight.
    assert np.ptp(record.acceleration[:10], axis=0).max() < 1e-3
    assert np.ptp(record.acceleration, axis=0).max() > 1.0


def test_path_truth_is_the_model_itself_pose_by_pose():
    from examples.paper import cell

    model = cell.robot()
    plan = cell.plan_pulses(model, 'P1', 0.0, 4.0, 3, 10.0)
    record = cell.shake(model, plan, 3)
    real = cell.truth(model, record, n_poses=5)
    rows = np.linspace(0, len(record.position) - 1, 5).round().astype(int)
    for row, found in zip(rows, real.over_path_hz, strict=True):
        alone = model.modes(record.position[row]).frequency_hz[: len(found)]
        assert np.sort(found) == pytest.approx(alone, rel=1e-9)


def test_measured_responses_are_those_of_the_model():
    """Six drives at once against the model's linear response; the lever arm at the low end."""
    from examples.paper import cell, frequency_responses

    model = cell.robot()
    noise = {**cell.STILL_NOISE, **frequency_responses.EVEN}
    plan = cell.plan_pulses(model, 'P2', 0.0, 0.0, 3, 40.0, **noise)
    frequency_hz, measured = frequency_responses.measured_response(
        model, cell.shake(model, plan, 3)
    )
    expected = frequency_responses.model_response(model, plan.start_position, frequency_hz)
    # Above, the drives follow so little that noise shows in a record this short.
    strong = frequency_hz < 35.0
    for row, column in ((0, 1), (1, 0)):
        ratio = measured[strong, row, column] / expected[strong, row, column]
        assert np.median(np.abs(20.0 * np.log10(np.abs(ratio)))) < 1.0, 'seed 3'
    # Axis 1 turns the spindle about the base: its lever arm is its distance from it.
    slow = frequency_responses.model_response(model, plan.start_position, np.array([0.05]))[0]
    arm_m = model.geometry.positions([plan.start_position], [('flange', np.array([0.2, 0, 0.08]))])
    assert np.abs(slow[1, 0]) == pytest.approx(arm_m[0, 0, 0], rel=0.01)


def test_three_batches_of_14_hold_every_one_of_42_points_once():
    from examples.paper import batches

    points = [sensor.name for sensor in batches.all_points()]
    assert len(set(points)) == 42
    roving = [[s.name for s in each if s.name in points] for each in batches.batches()]
    assert [len(names) for names in roving] == [14, 14, 14]
    assert sorted(name for names in roving for name in names) == sorted(points)
    staying = [{s.name for s in each} - set(points) for each in batches.batches()]
    assert staying == [set(batches.STAYING)] * 3


@pytest.mark.parametrize(
    ('was', 'now', 'same'),
    [
        ('9.50 ± 0.01', '9.51 ± 0.01', True),
        ('9.50 ± 0.01', '9.99 ± 0.01', True),
        ('9.50 ± 0.01', '-', False),
        ('4 of 7', '6 of 7', True),
        ('3', '6', False),
        ('reproduced', 'in part', False),
        ('1.24e-05', '1.25e-05', True),
        ('1.24e-05', '2.24e-05', False),
        ('-43.7', '43.7', False),
    ],
)
def test_tables_are_compared_within_what_machines_differ_by(was, now, same):
    from examples.paper import output

    assert output.alike(was, now) is same


def test_checking_names_every_cell_that_is_stale_and_writes_nothing():
    from examples.paper import output

    rows = output.kept('paper_pulses')
    keeper = output.Keeper(checks=True)
    keeper.rows('paper_pulses', (), [list(row) for row in rows], '')
    assert keeper.differences == []
    changed = [list(row) for row in rows]
    changed[1][1] = '77'
    keeper.rows('paper_pulses', (), changed, '')
    assert len(keeper.differences) == 1
    assert '77' in keeper.differences[0]
    keeper.rows('paper_pulses', (), rows[:-1], '')
    assert 'rows' in keeper.differences[1]
    assert output.kept('paper_pulses') == rows


def test_a_drawing_follows_the_theme_and_says_what_it_shows():
    pytest.importorskip('matplotlib')
    from examples.paper import drawing

    figure, axes = drawing.panels(1, 1, (3.0, 2.0))
    axes[0][0].plot([0, 1], [0, 1], color=drawing.COLOURS[0])
    axes[0][0].set_title('0.98765')
    import io

    written = io.StringIO()
    figure.savefig(written, format='svg')
    text = drawing.themed(written.getvalue(), 'a line')
    dark = dict(drawing.palette.SERIES)[drawing.COLOURS[0]]
    name = f'--c{drawing.COLOURS[0][1:]}'
    assert f'var({name}, {drawing.COLOURS[0]})' in text
    assert f'{name}: {dark};' in text
    assert 'aria-label="a line"' in text
    assert '>0.98765<' in text
    assert not any(f' {light}' in text.split('</style>')[1].replace(f', {light}', '')
                   for light, _ in drawing.palette.SERIES)  # fmt: skip


@pytest.mark.slow
def test_a_small_range_finds_the_true_modes_through_the_whole_chain():
    from examples.paper import self_excitation

    found = self_excitation.run('P1', 6.5, 8.5, self_excitation.AS_PAPER, seed=4, duration_s=60.0)
    pairs, mean_hz = found.pairs, found.truth.mean_hz
    assert {0, 1, 2, 3} <= set(pairs), 'seed 4'
    for index in range(4):
        assert pairs[index].frequency_hz == pytest.approx(mean_hz[index], rel=0.01), 'seed 4'


@pytest.mark.slow
def test_a_wide_range_smears_modes():
    from examples.paper import self_excitation

    narrow, wide = (
        self_excitation.run(
            'P1', 7.5 - half, 7.5 + half, self_excitation.AS_PAPER, seed=4, duration_s=60.0
        )
        for half in (1.0, 7.5)
    )

    def errors(found):
        return [abs(m.frequency_hz / found.truth.mean_hz[i] - 1) for i, m in found.pairs.items()]

    assert len(wide.pairs) < len(narrow.pairs) or max(errors(wide)) > 2 * max(errors(narrow))
    assert np.max(np.ptp(wide.truth.over_path_hz, axis=0) / wide.truth.mean_hz) > 0.1


@pytest.mark.slow
def test_joint_6_alone_is_weaker_and_drowns_in_noise():
    from examples.paper import all_joints

    found = all_joints.experiments(duration_s=40.0, orders=(40,), seed=5)
    level = {(each.joints, each.noise): each.peak_density for each in found}
    assert level['joint 6', 'quiet'] < 1e-3 * level['all joints', 'quiet'], 'seed 5'
    modes = {(each.joints, each.noise): len(each.pairs) for each in found}
    assert modes['joint 6', 'hall'] == 0 < modes['all joints', 'hall'], 'seed 5'
    ranks = [each.record.plan.torque_projection_rank for each in found]
    # Equal accelerations: about base x no joint but 4 and 6 turns, and little.
    assert ranks == [2, 2, 1, 1]
