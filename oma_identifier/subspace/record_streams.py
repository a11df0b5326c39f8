"""The bands of a window that slides over a record."""

from dataclasses import replace

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.covariance import Band, Decimation, plan_bands, WhenFull
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace.band_stream import BandCovariance, BandStream


class RecordStreams:
    """Block covariances of all bands of the newest window, each sample summed once.

    Parameters
    ----------
    settings : IdentificationSettings
        Band, orders and window length.
    """

    def __init__(self, settings: IdentificationSettings) -> None:
        self._settings = settings
        self._streams: list[BandStream] = []
        self._last: Samples | None = None
        self._decimation = Decimation()

    def add(self, samples: Samples) -> None:
        """Add what is new in a window; where it does not continue the last one, all starts again.

        Parameters
        ----------
        samples : Samples
            The window.
        """
        first = 0
        if self._last is not None and self._continues(self._last, samples):
            passed_ns = self._last.end_ns - samples.start_ns
            first = round(passed_ns * samples.sample_rate_hz / NANOSECONDS_PER_SECOND)
        else:
            self._start(samples)
        self._decimation.take(samples.acceleration[first:])
        for stream in self._streams:
            stream.add(self._decimation)
        self._decimation.drop()
        self._streams = [
            self._with_twice_the_orders(stream, samples) if stream.is_crowded() else stream
            for stream in self._streams
        ]
        empty = samples.acceleration[:0].copy()
        self._last = replace(samples, acceleration=empty, start_ns=samples.end_ns)

    @staticmethod
    def _continues(last: Samples, samples: Samples) -> bool:
        return (
            samples.channels == last.channels
            and samples.sample_rate_hz == last.sample_rate_hz
            and samples.start_ns <= last.start_ns <= samples.end_ns
        )

    def _start(self, samples: Samples) -> None:
        self._decimation = Decimation()
        bands = plan_bands(samples.sample_rate_hz, self._span_s(samples), self._settings)
        self._streams = [
            self._stream(band, samples, index % 4) for index, band in enumerate(bands)
        ]

    def _span_s(self, samples: Samples) -> float:
        return min(self._settings.window_s, samples.duration_s)

    def _stream(self, band: Band, samples: Samples, turn: int, fold: int = 1) -> BandStream:
        span_s = self._span_s(samples)
        return BandStream(band, self._settings, span_s, WhenFull.RETIRE, turn, fold)

    def _with_twice_the_orders(self, stream: BandStream, samples: Samples) -> BandStream:
        """Return the band's stream begun anew, with room for its modes."""
        roomier = self._stream(stream.band, samples, stream.turn, fold=2)
        window = Decimation()
        window.take(samples.acceleration)
        roomier.add(window)
        return roomier

    def results(self) -> list[BandCovariance | None]:
        """Return the covariances of all bands so far."""
        return [stream.result() for stream in self._streams]
