"""A search from top to bottom: tolerances, rounds of one effect each, rivals."""

from collections.abc import Callable

from modal_core.work.progress import Progress
from model_gap.search.rivals import confirm
from model_gap.search.search import Search
from model_gap.search.steps import (
    close_round,
    confirm_best,
    fit_again_without,
    fit_finely,
    fit_roughly,
    fit_tolerances,
    screen_again,
    screen_catalogue,
    seek_hanging,
    seek_lines,
    settle_best,
    stop_or_go_on,
    take_out_second_order,
)
from model_gap.search.thresholds import SEARCH

Step = Callable[[Search], Search]
# Each with the share of the round's work that is done after it.
ROUND: tuple[tuple[Step, float], ...] = (
    (seek_lines, 0.1),
    (seek_hanging, 0.12),
    (screen_catalogue, 0.25),
    (screen_again, 0.4),
    (fit_roughly, 0.65),
    (fit_finely, 0.85),
    (fit_again_without, 0.85),
    (close_round, 0.85),
    (settle_best, 0.9),
    (take_out_second_order, 0.95),
    (confirm_best, 0.95),
    (stop_or_go_on, 1.0),
)


def run_search(
    search: Search,
    progress: Progress = lambda _: None,
    first: Callable[[Search], None] = lambda _: None,
) -> Search:
    """Search until nothing more is worth adding.

    Parameters
    ----------
    search : Search
        As :meth:`Search.begin` gives it.
    progress : callable
        Takes the fraction done; all of it is not said, for more may follow.
    first : callable
        Takes the search once tolerances are fitted.
    """
    search = fit_tolerances(search)
    first(search)
    while len(search.rounds) < search.settings.most_effects and not search.finished:
        search = run_round(search, progress)
    return confirm(search)


def tolerances_only(search: Search, first: Callable[[Search], None] = lambda _: None) -> Search:
    """Return a search that tries no effect: its round holds what tolerances leave over."""
    search = fit_tolerances(search)
    first(search)
    return close_round(search)


def run_round(search: Search, progress: Progress) -> Search:
    """Look for one more effect."""
    done = len(search.rounds)
    begun, ends = (
        1.0 - SEARCH.left_at_first * SEARCH.left_after**number for number in (done, done + 1)
    )
    progress(begun)
    for step, share in ROUND:
        search = step(search)
        progress(begun + share * (ends - begun))
        if search.finished:
            break
    return search
