"""Run a search: the steps of :data:`ROUND`, round by round, until nothing is worth adding."""

from collections.abc import Callable

from model_gap.search.rivals import confirm
from model_gap.search.search import Search
from model_gap.search.steps import fit_tolerances, ROUND

# Of the whole work, what is left before the first round, and of that after each: what is left
# after a round is mostly less than it.
LEFT_AT_FIRST = 0.9
LEFT_AFTER = 0.4


def run_search(search: Search, progress: Callable[[float], None] = lambda _: None) -> Search:
    """Search until nothing more is worth adding.

    Parameters
    ----------
    search : Search
        As :meth:`Search.begin` gives it.
    progress : callable
        Takes the fraction done.
    """
    search = fit_tolerances(search)
    for number in range(search.settings.most_effects):
        begun, ends = (1.0 - LEFT_AT_FIRST * LEFT_AFTER**n for n in (number, number + 1))
        progress(begun)
        for step, share in ROUND:
            search = step(search)
            progress(begun + share * (ends - begun))
            if search.finished:
                break
        if search.finished:
            break
    search = confirm(search)
    progress(1.0)
    return search
