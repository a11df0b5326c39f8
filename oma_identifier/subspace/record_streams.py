"""The bands of one continuous record, fed with windows that overlap."""

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.covariance import Band, Decimation, plan_bands, WhenFull
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace.band_stream import BandCovariance, BandStream


class RecordStreams:
    """Block covariances of all bands of a record, each sample counted once.

    Parameters
    ----------
    settings : IdentificationSettings
        Band, orders and window length.
    when_full : WhenFull
        RETIRE for the newest window, JOIN for the whole record.
    """

    def __init__(self, settings: IdentificationSettings, when_full: WhenFull) -> None:
        self._settings = settings
        self._when_full = when_full
        self._streams: list[BandStream] = []
        self._last: Samples | None = None
        self._began_ns = 0
        self._ahead: list[BandStream] = []
        self._leads: dict[Band, BandStream] = {}
        self._decimation = Decimation()
        self._shares: bool | None = None

    def add(self, samples: Samples, ahead: 'RecordStreams | None' = None) -> None:
        """Add what is new in a window.

        Where it does not continue the last one, a sliding window starts again; a whole record
        goes on after the gap.

        Parameters
        ----------
        samples : Samples
            The window.
        ahead : RecordStreams or None
            Streams that the same windows were added to: where they are in step, their blocks are
            taken, and no sample is conditioned and summed twice.
        """
        first = 0
        if self._last is not None and self._continues(samples):
            passed_ns = self._last.end_ns - samples.start_ns
            first = round(passed_ns * samples.sample_rate_hz / NANOSECONDS_PER_SECOND)
        elif self._goes_on(samples):
            self._interrupt()
        else:
            self._start(samples)
        leads = self._in_step(ahead, samples, first)
        rows = samples.acceleration[first:]
        shared = self._shared(ahead, leads, len(rows))
        self._decimation.take(rows, shared)
        for stream in self._streams:
            lead = leads.get(stream.band)
            if lead is None or not stream.follow(lead):
                stream.add(self._decimation)
        self._decimation.drop()
        self._last = Samples(
            samples.acceleration[:0].copy(),
            samples.sample_rate_hz,
            samples.channels,
            samples.end_ns,
        )

    def _interrupt(self) -> None:
        self._decimation, self._shares = Decimation(), None
        for stream in self._streams:
            stream.interrupt()

    def _shared(
        self, ahead: 'RecordStreams | None', leads: dict[Band, BandStream], n_rows: int
    ) -> Decimation | None:
        """Return what others made of the same rows, as long as they have done so every time."""
        same = ahead is not None and bool(leads) and ahead._decimation.n_rows == n_rows
        if self._shares and not same:
            self._decimation = Decimation()
            for stream in self._streams:
                stream.refilter()
        self._shares = same and self._shares is not False
        return ahead._decimation if ahead is not None and self._shares else None

    def _in_step(
        self, ahead: 'RecordStreams | None', samples: Samples, first: int
    ) -> dict[Band, BandStream]:
        """Return streams that began with the very sample that was next here, by band."""
        if ahead is None:
            return {}
        if ahead._streams is not self._ahead:
            self._ahead = ahead._streams
            together = first == 0 and ahead._began_ns == samples.start_ns
            self._leads = {stream.band: stream for stream in self._ahead} if together else {}
        return self._leads

    def _same_grid(self, samples: Samples) -> bool:
        last = self._last
        return (
            last is not None
            and samples.channels == last.channels
            and samples.sample_rate_hz == last.sample_rate_hz
        )

    def _continues(self, samples: Samples) -> bool:
        last = self._last
        return (
            last is not None
            and self._same_grid(samples)
            and samples.start_ns <= last.start_ns <= samples.end_ns
        )

    def _goes_on(self, samples: Samples) -> bool:
        last = self._last
        return (
            last is not None
            and self._when_full is WhenFull.JOIN
            and self._same_grid(samples)
            and samples.start_ns > last.start_ns
        )

    def _start(self, samples: Samples) -> None:
        self._began_ns = samples.start_ns
        self._decimation, self._shares = Decimation(), None
        window_s = self._settings.window_s
        # The length of the whole record is not known yet: plan for an endless one.
        duration_s = min(window_s, samples.duration_s)
        if self._when_full is WhenFull.JOIN:
            duration_s = float('inf')
        bands = plan_bands(samples.sample_rate_hz, duration_s, self._settings)
        span_s = min(window_s, samples.duration_s)
        self._streams = [
            BandStream(band, self._settings, span_s, self._when_full, turn=index % 4)
            for index, band in enumerate(bands)
        ]

    def release(self) -> None:
        """Forget the samples added last: no other streams will go ahead with them."""
        self._decimation.drop_all()

    @property
    def follows(self) -> tuple[bool, ...]:
        """Of each band, whether it takes the blocks of the streams ahead."""
        return tuple(stream.follows for stream in self._streams)

    def results(self) -> list[BandCovariance | None]:
        """Return the covariances of all bands so far."""
        return [stream.result() for stream in self._streams]
