"""What is told of the channels of a recording: what most of its windows show, and no chance."""

from modal_core.quality import ChannelQuality, DataQuality
from modal_reports import far_channels, interrupted_channels, poor_channels


def windows(*of_windows):
    return [
        DataQuality(
            channels=tuple(
                ChannelQuality(name, excluded=excluded, flags=flags)
                for name, (excluded, flags) in channels.items()
            )
        )
        for channels in of_windows
    ]


def test_channels_left_out_are_told_with_the_reason_and_how_often():
    healthy, dead = (False, ('gap',)), (True, ('flatline', 'not_finite'))
    later = (True, ('clipping',))
    found = windows(
        *[{'a': healthy, 'b': dead, 'c': healthy, 'd': dead}] * 6,
        *[{'a': healthy, 'b': dead, 'c': later, 'd': dead}] * 2,
    )
    assert poor_channels(found) == (
        'left out: b and d (values that are not numbers);'
        ' c (signal clipped at the sensor range in 2 of 8 windows)',
    )


def test_what_few_windows_show_is_not_told():
    healthy, odd, out = (False, ()), (False, ('incoherent',)), (True, ('not_synchronous',))
    few = windows(*[{'a': healthy, 'b': healthy}] * 10, {'a': odd, 'b': out})
    assert poor_channels(few) == ()
    most = windows({'a': healthy}, *[{'a': odd}] * 2)
    assert poor_channels(most) == ('to be looked at: a (another motion than the other sensors)',)
    assert poor_channels([]) == ()


def test_when_a_channel_was_not_heard_is_told_once_for_windows_that_overlap():
    def window(*spans_s, excluded=False):
        spans = tuple((round(1e9 * a), round(1e9 * b)) for a, b in spans_s)
        loose = ChannelQuality(
            'a', interrupted_ns=spans, excluded=excluded, flags=('interrupted',) * bool(spans)
        )
        return DataQuality(channels=(loose, ChannelQuality('b')))

    filled = [window(), window((105.0, 108.0)), window((105.0, 110.0)), window()]
    assert interrupted_channels(filled, 100_000_000_000) == (
        'a: nothing of what the other sensors show at 5.0 to 10.0 s (5 s in all, filled in from'
        ' the others); check its cable and plug',
    )
    out = [window((1.0, 30.0), excluded=True), window((40.0, 41.0))]
    (line,) = interrupted_channels(out, 0)
    assert 'at 1.0 to 30.0 and 40.0 to 41.0 s (30 s in all, left out of 1 window)' in line
    assert interrupted_channels([window()], 0) == ()


def test_far_values_are_told_once_for_windows_that_overlap():
    def window(*far_values):
        return DataQuality(channels=(ChannelQuality('a', far_values=far_values),))

    sparks = [(9, 70.0 + n, 1) for n in range(4)]
    found = [window((1, 9999.0, 3), (2, 9999.0, 4)), window((2, 9999.0, 4), *sparks)]
    (line,) = far_channels(found)
    assert line.startswith('a: 7 x 9999, 1 x ')
    assert line.endswith('2 other values m/s^2, far outside of all else, taken as lost')
    assert far_channels([window()]) == ()
