"""What happened, line by line."""

from modal_dashboard.screens.board import Update
from modal_dashboard.screens.cell_screens import BridgeNews, PlanNews
from modal_dashboard.screens.checks import Check, CheckStep
from modal_history.kept import KeptWindow
from modal_reports import count, listed

BAD = 'bad'


class RunLog:
    """Makes lines of what comes, and none of what says the same again."""

    def __init__(self) -> None:
        self._bridge = self._plan = self._reason = ''
        self._ids: set[int] | None = None

    def window(self, window: KeptWindow, now_s: float) -> list[Update]:
        """Return the line of a result that has other modes than the last, or none for a reason."""
        name, quality = f'window {window.index}', window.quality
        before, self._reason = self._reason, '' if quality.identifiable else quality.reason
        if not quality.identifiable:
            words = f'{name}: not identifiable, {quality.reason}'
            return [] if before == quality.reason else [_line(now_s, words, BAD)]
        ids = {mode.id for mode in window.modes if not mode.harmonic}
        known, self._ids = self._ids, ids
        if ids == known and not before:
            return []
        changes = (
            [] if known is None else [_named('new', ids - known), _named('gone', known - ids)]
        )
        words = '; '.join((count(len(ids), 'mode'), *filter(None, changes)))
        return [_line(now_s, f'{name}: {words}')]

    def check(self, check: Check, now_s: float) -> list[Update]:
        """Return the line of a check that changed."""
        bad = check.step != CheckStep.OK
        return [_line(now_s, f'{check.name}: {check.message}', BAD if bad else '')]

    def bridge(self, news: BridgeNews, now_s: float) -> list[Update]:
        """Return the line of a bridge that changed its state."""
        if news.words == self._bridge:
            return []
        self._bridge = news.words
        return [_line(now_s, f'bridge {news.words}', BAD if news.is_bad else '')]

    def plan(self, news: PlanNews, now_s: float) -> list[Update]:
        """Return the line of a new plan."""
        if news.plan_hash == self._plan:
            return []
        self._plan = news.plan_hash
        return [_line(now_s, news.words)]

    def refused(self, words: str, now_s: float) -> list[Update]:
        """Return the line of a message that cannot be shown."""
        return [_line(now_s, words, BAD)]


def _named(word: str, ids: set[int]) -> str:
    return f'{word}: {listed([str(each) for each in sorted(ids)])}' if ids else ''


def _line(now_s: float, words: str, kind: str = '') -> Update:
    return Update.of('log', {'time_s': now_s, 'words': words, 'kind': kind})
