"""Controller time to host time, free of the network's jitter."""

WINDOW_US = 1_000_000
NANOSECONDS_PER_MICROSECOND = 1000


class ClockMap:
    """The smallest delay seen lately is taken for the delay of every packet.

    Two windows of one second each give the minimum over the last one to two seconds, so that a
    slow drift between the clocks is followed.  A controller whose clock stands still gets the
    times of receipt.
    """

    def __init__(self) -> None:
        self._window = -1
        self._lowest: tuple[int, int] | None = None
        self._last_us = -1

    def stamp_ns(self, controller_us: int, receipt_ns: int) -> int:
        """Return the host time of a controller time.

        Parameters
        ----------
        controller_us : int [µs]
            Controller clock in the packet.
        receipt_ns : int [ns]
            Host clock at its receipt.
        """
        if controller_us == self._last_us:
            return receipt_ns
        offset = receipt_ns - controller_us * NANOSECONDS_PER_MICROSECOND
        window = controller_us // WINDOW_US
        jumped = not 0 <= controller_us - self._last_us < 2 * WINDOW_US
        if self._lowest is None or jumped:
            self._lowest = (offset, offset)
        elif window != self._window:
            self._lowest = (self._lowest[1], offset)
        else:
            self._lowest = (self._lowest[0], min(self._lowest[1], offset))
        self._window, self._last_us = window, controller_us
        return controller_us * NANOSECONDS_PER_MICROSECOND + min(self._lowest)
