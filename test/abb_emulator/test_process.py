"""The spindle at the emulated arm's tool: lines where they belong, chatter where it belongs."""

import math

import numpy as np
import pytest

from abb_emulator.cell import ArmSide, CellSettings
from abb_emulator.process import ProcessSettings, speed_message, SpindleProcess
from machining.cut import Coefficients, Cut, Cutter, Engagement
from machining.stability import DepthSearch, limits_of_periods
from modal_core.errors import SettingsError
from modal_core.tool_modes import ToolModes
from structural_model.robot_files import load_robot

RATE_HZ = 2048.0


def forces(settings, n, rate_hz=RATE_HZ, motion=None):
    process = SpindleProcess(settings, 1.0 / rate_hz)
    process.prepare(n)
    motion = np.zeros((n + 1, 3)) if motion is None else motion
    return process, np.array([process.step(motion[i], motion[i + 1]) for i in range(n)])


def amplitude(course, order_hz, rate_hz=RATE_HZ):
    time = np.arange(1, len(course) + 1) / rate_hz
    return 2.0 * abs(np.mean(course * np.exp(-2j * np.pi * order_hz * time)))


def test_unbalance_and_bearings_are_lines_of_their_orders():
    settings = ProcessSettings(
        speed_rpm=3600.0, unbalance_g_mm=1000.0, bearing_orders=(0.4, 0.0, 0.0), bearing_n=3.0
    )
    process, made = forces(settings, 2048 * 5)
    # m r Ω² = 1e-3 kg m · (2π 60)²·1e-3 = 142.1 N·1e-3
    expected = 1e-6 * 1000.0 * (2 * math.pi * 60.0) ** 2
    # The mean over a sample takes sinc(60 / 2048) away: a thousandth.
    assert amplitude(made[:, 0], 60.0) == pytest.approx(expected, rel=2e-3)
    assert amplitude(made[:, 1], 24.0) == pytest.approx(3.0, rel=2e-3)
    assert [(line.name, line.order) for line in process.lines] == [
        ('unbalance', 1.0),
        ('bearing 0.4', 0.4),
    ]


def test_the_cut_has_the_mean_force_of_its_closed_form():
    """Half-immersion up milling: −67.159 and 24.496 N (N = 4, a = 2 mm, c = 0.05 mm)."""
    settings = ProcessSettings(
        speed_rpm=3000.0, n_teeth=4, diameter_mm=20.0, radial_depth_mm=10.0, depth_mm=2.0,
        feed_mm=0.05, tangential_n_mm2=700.0, radial_n_mm2=210.0, tangential_edge_n_mm=12.0,
        radial_edge_n_mm=15.0,
    )  # fmt: skip
    _, made = forces(settings, 2048)
    assert made.mean(axis=0) == pytest.approx([-67.159, 24.496, 0.0], abs=0.1)


def test_runout_makes_the_line_of_the_spindle():
    cut = {'speed_rpm': 3000.0, 'depth_mm': 1.0, 'regeneration': False}
    _, true = forces(ProcessSettings(**cut), 4096)
    _, off = forces(ProcessSettings(**cut, runout_um=10.0), 4096)
    assert amplitude(true[:, 1], 50.0) < 1e-2
    assert amplitude(off[:, 1], 50.0) > 5.0
    assert amplitude(off[:, 1], 100.0) == pytest.approx(amplitude(true[:, 1], 100.0), rel=0.2)


def test_a_displacement_is_felt_now_and_taken_back_a_tooth_later():
    """A step of the tool by a hundredth of a millimetre into a slot, no more than regeneration."""
    n, at = 1200, 600
    motion = np.zeros((n + 1, 3))
    motion[at:, 0] = 1e-5
    settings = {
        'speed_rpm': 1200.0, 'n_teeth': 2, 'diameter_mm': 10.0, 'radial_depth_mm': 10.0,
        'depth_mm': 1.0,
    }  # fmt: skip
    _, moved = forces(ProcessSettings(**settings), n, motion=motion)
    _, still = forces(ProcessSettings(**settings), n)
    _, stiff = forces(ProcessSettings(**settings, regeneration=False), n, motion=motion)
    change = np.abs(moved - still).max(axis=1)
    period = round(60.0 / (2 * 1200.0) * RATE_HZ)
    assert change[: at - 2].max() == 0.0
    assert change[at : at + period].max() > 0.5 * 8e8 * 1e-3 * 1e-5
    assert change[at + period + 3 :].max() < 1e-9
    assert np.array_equal(stiff, still)


def test_a_ramp_moves_the_lines_and_is_published():
    settings = ProcessSettings(speed_rpm=3000.0, speed_rate_rpm_s=600.0, unbalance_g_mm=100.0)
    process, made = forces(settings, 2048 * 4)
    late = made[-2048:, 0]
    turned = (
        2.0
        * np.pi
        * (50.0 * np.arange(1, 8193) / RATE_HZ + 0.5 * 10.0 * (np.arange(1, 8193) / RATE_HZ) ** 2)
    )
    fit = np.abs(np.mean(late * np.exp(-1j * turned[-2048:]))) * 2
    assert fit == pytest.approx(np.sqrt(2.0) * late.std(), rel=0.05)
    assert float(process.speed_rpm(2.0)) == 4200.0
    message = speed_message(4200.0, 5)
    assert np.frombuffer(message.data[4:], '<f8')[0] == 4200.0


def rings(settings, seconds=6):
    model = load_robot('irb6660_205_190')
    pose = model.pose('P1')
    cell = CellSettings(sample_rate_hz=RATE_HZ, process=settings)
    arm = ArmSide(model, (), np.degrees(model.to_controller(pose)), cell).arm
    n = round(RATE_HZ)
    still = np.zeros((n, len(pose)))
    rms = []
    for _ in range(seconds):
        bent = arm.advance(np.tile(pose, (n, 1)), still, still).deflection
        tool = bent @ model.sensor_jacobian(pose, arm.process.channels).T
        rms.append(tool[:, 0].std())
    return np.array(rms)


def test_the_arm_chatters_where_semi_discretisation_says():
    """Physics of the emulator's own, teeth that leave the cut and all, against the prediction."""
    slot = {'speed_rpm': 6000.0, 'diameter_mm': 12.0, 'radial_depth_mm': 12.0}
    model = load_robot('irb6660_205_190')
    pose = model.pose('P1')
    channels = SpindleProcess(ProcessSettings(**slot), 1.0 / RATE_HZ).channels
    shapes = model.modes(pose, channels).channel_shapes.T
    damped = model.damped_modes(pose)
    tool = ToolModes(damped.frequency_hz, damped.damping_ratio, shapes)
    cut = Cut(Cutter(2, 0.012), Engagement.slot(), Coefficients(800e6, 250e6))
    (limit,) = limits_of_periods(tool, cut, [6000.0], DepthSearch(1e-4, 0.02)).depth_m
    shallow = rings(ProcessSettings(**slot, depth_mm=0.85e3 * limit))
    deep = rings(ProcessSettings(**slot, depth_mm=1.25e3 * limit))
    assert shallow[-1] < 1.01 * shallow[-3]
    # 1.5 times the depth is 1.5 times the force; the rest is chatter that has grown.
    assert deep[-1] > 5.0 * shallow[-1]


@pytest.mark.parametrize(
    'wrong',
    [
        {'way': 'sideways'},
        {'radial_depth_mm': 30.0},
        {'feed_axis': (1.0, 0.0, 0.0), 'spindle_axis': (1.0, 0.0, 0.0)},
        {'position_m': (0.0, 0.0)},
    ],
)
def test_what_is_no_process_is_refused_in_one_line(wrong):
    with pytest.raises(SettingsError) as caught:
        SpindleProcess(ProcessSettings(speed_rpm=1000.0, **wrong), 1e-3)
    assert '\n' not in str(caught.value)
