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
    assert ranks == [3, 3, 1, 1]
