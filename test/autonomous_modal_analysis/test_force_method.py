"""`ama identify --method force`: a table with a force gives masses; without it one line."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter
from typer.testing import CliRunner

from autonomous_modal_analysis.cli import app

SEED, RATE_HZ, N = 700_501, 64.0, 2560
F_HZ, ZETA, MASS_KG = 9.0, 0.02, 5.0


def table(path, with_force=True):
    """One mass on a spring, a force that sweeps, and one that nobody measured."""
    rng = np.random.default_rng(SEED)
    omega, step = 2.0 * np.pi * F_HZ, 1.0 / RATE_HZ
    time = np.arange(N) * step
    force = 20.0 * np.sin(2.0 * np.pi * (3.0 * time + 0.2 * time**2))
    force += 5.0 * rng.standard_normal(N)
    own = force + 3.0 * rng.standard_normal(N)
    # Displacement by the impulse response of bands up to half the rate: exact for these sums.
    line = 2.0 * np.pi * np.fft.rfftfreq(4 * N, step)
    response = -(line**2) / (omega**2 - line**2 + 2j * ZETA * omega * line) / MASS_KG
    rows = np.fft.irfft(np.fft.rfft(own, 4 * N) * response)[:N]
    rows += 0.02 * rows.std() * rng.standard_normal(N)
    other = 0.6 * rows + 0.02 * rows.std() * lfilter([1.0], [1.0], rng.standard_normal(N))
    columns = [time, rows, other, *([force] if with_force else [])]
    heads = ['time [s]', 'tool [m/s^2]', 'arm [m/s^2]', *(['force@tool [N]'] * with_force)]
    np.savetxt(path, np.column_stack(columns), '%.8g', ',', header=','.join(heads), comments='')
    return path


@pytest.mark.slow
def test_modes_and_masses_of_a_table_with_a_force(tmp_path):
    print('seed', SEED)
    file = table(tmp_path / 'cut.csv')
    options = ['--method', 'force', '--window-s', '40', '--out', str(tmp_path / 'out')]
    said = CliRunner().invoke(app, ['identify', str(file), *options])
    assert said.exit_code == 0, said.output
    (mode,) = json.loads((tmp_path / 'out' / 'modal_masses.json').read_text())['modes']
    assert mode['frequency_hz'] == pytest.approx(F_HZ, rel=5e-3)
    assert mode['modal_mass_kg'] == pytest.approx(MASS_KG, rel=0.05)
    assert abs(mode['modal_mass_kg'] - MASS_KG) < 4.0 * mode['modal_mass_std_kg']
    assert 'modal mass' in said.output
    assert 'left out' not in said.output  # the force takes part


def test_a_table_without_a_force_is_refused_in_one_line(tmp_path):
    from modal_core.errors import RecordingError

    file = table(tmp_path / 'plain.csv', with_force=False)
    said = CliRunner().invoke(app, ['identify', str(file), '--method', 'force'])
    assert said.exit_code == 2 or isinstance(said.exception, RecordingError)
    text = said.output + str(said.exception or '')
    assert 'no force channel' in text and 'one column in N' in text
