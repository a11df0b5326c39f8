"""A month of a robot at one result a minute: false alarms, and changes of stiffness."""

import sqlite3

import numpy as np
import pytest

from modal_core.errors import SettingsError
from modal_history.alarm import (
    acknowledge,
    AlarmCheck,
    alarms_of,
    BaselineSettings,
    keep_alarms,
    learn,
    needed_since,
    watch,
    WatchSettings,
)
from modal_history.reader import HistoryReader
from test.support.kept_results import softened
from test.support.months import Month, START_NS

HOUR_NS, DAY_NS = 3600 * 10**9, 86_400 * 10**9


def changes(month):
    """Return the first change of every mode, watched together."""
    found = []
    for trend in month.trends():
        baseline = learn(trend)
        found.append(watch(trend, baseline, n_modes=3))
    return found


@pytest.mark.slow
def test_a_usual_month_raises_no_alarm():
    """Seed 31: daily and weekly temperature, twelve poses, three loads, slow scatter, outliers."""
    found = changes(Month(30, 31))
    assert [each.change for each in found] == [None] * 3
    assert all(each.n > 30_000 and each.n_left_out == 0 for each in found)
    # And it was not blind: half a per cent would not have gone unnoticed.
    assert all(each.detectable < 5e-3 for each in found)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(40, 60))
def test_months_of_all_kinds_raise_few_alarms(seed, record_property):
    """Stated is one in ten months; with poses from anywhere, and without a temperature too."""
    found = changes(Month(30, seed, free=seed % 4 == 3, knows_temperature=seed % 5 != 4))
    n_false = sum(each.change is not None for each in found)
    record_property('false alarms', n_false)
    assert n_false <= 1, seed


@pytest.mark.parametrize(
    ('lost', 'hours', 'seed'),
    [((0.0, 0.0, 0.01), 24.0, 71), ((0.01, 0.0, 0.0), 24.0, 72), ((0.0, 0.0, 0.03), 2.0, 73)],
)
def test_a_loss_of_stiffness_is_found_in_time(lost, hours, seed):
    """The joint takes part in one mode nearly alone; a frequency falls by half its share."""
    at = 7.5
    usual = changes(Month(9, seed))
    assert [each.change for each in usual] == [None] * 3, f'seed {seed}'
    trends = Month(9, seed, lost=lost, at_day=at).trends()
    found = [each.change for each in changes(Month(9, seed, lost=lost, at_day=at)) if each.change]
    assert found, f'seed {seed}'
    first = min(found, key=lambda change: change.raised_ns)
    begin_ns = START_NS + round(at * DAY_NS)
    assert begin_ns < first.raised_ns < begin_ns + hours * HOUR_NS, f'seed {seed}: {first}'
    before, after = Month(9, seed).trends()[first.id - 1], trends[first.id - 1]
    there = after.time_ns > begin_ns
    truth = float(np.mean(after.frequency_hz[there] / before.frequency_hz[there])) - 1.0
    assert abs(first.share - truth) < 3.5 * first.share_std, f'seed {seed}: {first}, {truth}'
    assert abs(first.since_ns - begin_ns) < 0.1 * max(hours, 10.0) * HOUR_NS, f'seed {seed}'


def test_what_repeats_itself_counts_once():
    """Overlapping windows tell the same ten times: neither surer nor sooner an alarm."""
    month = Month(20, 81, wander=3e-3)
    found = changes(month)
    assert [each.change for each in found] == [None] * 3
    # A scatter of 0.3 % that lasts for hours hides what a mean of single results would show.
    assert all(each.detectable > 2e-3 for each in found)


def test_an_hour_is_no_baseline():
    trend = Month(2, 5).trends()[0]
    assert learn(trend) is None
    assert learn(trend, BaselineSettings(days=1.0)) is not None


# -- kept until acknowledged ---------------------------------------------------------------------


def look(path, check=None):
    check = check or AlarmCheck(BaselineSettings(days=0.08), WatchSettings())
    with HistoryReader(path) as reader:
        return check.check(reader, 'arm')


def test_an_alarm_stays_until_it_is_acknowledged_and_is_usual_then(tmp_path):
    path = softened(tmp_path / 'arm.history')
    found = look(path)
    (alarm,) = found.new
    assert alarm.change.id == 1 and alarm.change.share == pytest.approx(-0.015, abs=0.002)
    assert 'since 2026-' in alarm.words() and '\n' not in alarm.words()
    keep_alarms(path, found.new)
    keep_alarms(path, found.new)
    assert look(path).new == ()
    with HistoryReader(path) as reader:
        (kept,) = alarms_of(reader.file)
    assert kept.is_open and kept.change == alarm.change
    with pytest.raises(SettingsError, match='no such open alarm'):
        acknowledge(path, 7)
    acknowledge(path, kept.number)
    assert look(path).new == ()
    with HistoryReader(path) as reader:
        assert not alarms_of(reader.file)[0].is_open


def test_a_check_that_goes_on_finds_what_a_new_one_finds(tmp_path):
    """A node looks again and again, and reads what is new only."""
    check = AlarmCheck(BaselineSettings(days=0.08), WatchSettings())
    for n_windows in (100, 160, 190):
        softened(tmp_path / 'arm.history', n_windows)
        assert look(tmp_path / 'arm.history', check).new == ()
    softened(tmp_path / 'arm.history')
    (found,) = look(tmp_path / 'arm.history', check).new
    (anew,) = look(tmp_path / 'arm.history').new
    assert found.change == anew.change


@pytest.mark.slow
def test_months_are_gone_on_with_as_they_are_read_anew():
    """Seed 91: a month in pieces of five days and as a whole; a change at its end."""
    (trend, *_) = Month(30, 91, lost=(0.02, 0.0, 0.0), at_day=27.0).trends()
    baseline, since, found = learn(trend), 0, None
    for day in range(10, 31, 5):
        there = (trend.time_ns >= since) & (trend.time_ns <= START_NS + day * DAY_NS)
        part = trend.rows(np.flatnonzero(there))
        found = watch(part, baseline).change
        if found is not None:
            break
        since = needed_since(part, baseline)
    whole = watch(trend, baseline).change
    assert found is not None and whole is not None, 'seed 91'
    assert abs(found.raised_ns - whole.raised_ns) < HOUR_NS
    assert found.share == pytest.approx(whole.share, abs=found.share_std)


def test_a_history_of_before_there_were_alarms_is_brought_up_to_date(tmp_path):
    path = softened(tmp_path / 'arm.history')
    rows = sqlite3.connect(path)
    rows.execute('DROP TABLE alarm')
    rows.execute('PRAGMA user_version = 1')
    rows.close()
    found = look(path)
    assert len(found.new) == 1
    keep_alarms(path, found.new)
    with HistoryReader(path) as reader:
        assert len(alarms_of(reader.file)) == 1
