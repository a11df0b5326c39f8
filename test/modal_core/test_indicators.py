from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from modal_core.numbers.indicators import mac, mpc, mpd, normalise, rotate_to_real

SHAPES = np.array([[1.0, 1.0], [0.5, -1.0], [0.2, 0.3]]) + 0j
complex_scale = st.complex_numbers(min_magnitude=1e-3, max_magnitude=1e3)


def test_mac_of_a_shape_with_itself_is_one_and_of_orthogonal_shapes_zero():
    np.testing.assert_allclose(np.diag(mac(SHAPES, SHAPES)), 1.0)
    assert mac([1, 0], [0, 1]).item() == 0.0


def test_mac_matches_its_definition():
    a, b = SHAPES.T
    expected = abs(np.vdot(a, b)) ** 2 / (np.vdot(a, a) * np.vdot(b, b)).real
    np.testing.assert_allclose(mac(a, b).item(), expected)


def test_mac_of_a_zero_shape_is_zero():
    assert mac([0, 0], [1, 2]).item() == 0.0


@given(scale=complex_scale, seed=st.integers(0, 2**31))
def test_indicators_do_not_change_with_complex_scale(scale, seed):
    rng = np.random.default_rng(seed)
    shape = rng.normal(size=(5, 1)) + 1j * rng.normal(size=(5, 1))
    other = rng.normal(size=(5, 1)) + 1j * rng.normal(size=(5, 1))
    message = f'seed {seed}'
    np.testing.assert_allclose(
        mac(scale * shape, other), mac(shape, other), atol=1e-9, err_msg=message
    )
    np.testing.assert_allclose(mpc(scale * shape), mpc(shape), atol=1e-9, err_msg=message)
    np.testing.assert_allclose(mpd(scale * shape), mpd(shape), atol=1e-7, err_msg=message)


@given(scale=complex_scale)
def test_a_real_mode_turned_by_any_phase_has_mpc_one_and_mpd_zero(scale):
    shape = scale * np.array([[1.0], [-0.4], [0.7]])
    np.testing.assert_allclose(mpc(shape), 1.0)
    np.testing.assert_allclose(mpd(shape), 0.0, atol=1e-7)


def test_a_travelling_wave_has_mpc_zero_and_the_largest_mpd():
    wave = np.exp(2j * np.pi * np.arange(8) / 8)[:, None]
    np.testing.assert_allclose(mpc(wave), 0.0, atol=1e-12)
    # Phases spread evenly about any line: mean of |angle to the line| is π/4.
    np.testing.assert_allclose(mpd(wave), np.pi / 4, rtol=0.02)


def test_mpd_of_two_entries_a_known_angle_apart():
    angle = np.deg2rad(20.0)
    shape = np.array([[1.0], [np.exp(1j * angle)]])
    np.testing.assert_allclose(mpd(shape), angle / 2)


def test_rotation_to_the_real_axis_keeps_magnitudes():
    shape = np.array([[1.0], [0.9j + 0.1]])
    turned = rotate_to_real(shape)
    np.testing.assert_allclose(np.abs(turned), np.abs(shape))
    assert np.sum(turned.imag**2) <= np.sum(turned.real**2)


def test_normalised_shape_has_largest_entry_one():
    shape = normalise(np.array([1j, -2j, 0.5]))
    assert shape[1] == 1.0
    assert np.abs(shape).max() == 1.0


@pytest.mark.parametrize('indicator', [mpc, mpd])
def test_zero_shape_gives_a_number(indicator):
    assert np.isfinite(indicator(np.zeros((3, 1)))).all()


def test_one_channel_tells_nothing_of_phases():
    lone = np.array([[1.0 + 0.5j, -2.0j]])
    assert np.isnan([*mpc(lone), *mpd(lone)]).all()
