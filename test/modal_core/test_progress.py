"""How much is done of work that turns out to be longer."""

from modal_core.work.progress import as_much_again


def test_where_as_much_again_follows_half_is_done_at_first():
    told = []
    again = as_much_again(told.append)
    for done in (0.0, 0.5, 1.0):
        again(done)
    assert told == [0.5, 0.75, 1.0]
    as_much_again(again)(0.0)
    assert told[-1] == 0.75
