"""What is told of the channels of a recording: what most of its windows show, and no chance."""

from modal_core.quality import ChannelQuality, DataQuality
from modal_reports import poor_channels


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
