"""The controller's end of the UDP link: it speaks first, and reads one datagram per cycle."""

from collections import deque
import socket

from abb_emulator.egm.link_faults import LinkFaults
from modal_core.errors import BridgeError

Address = tuple[str, int]
QUEUE_LENGTH = 512
LARGEST_BYTES = 4096


class UdpClient:
    """Sends to the sensor and queues what comes back from there, first in first out.

    A datagram of another host, or of another port of that host, is ignored and counted.

    Parameters
    ----------
    remote : (address, port)
        Where the sensor listens (the Remote Address of the UDP device).
    faults : LinkFaults
        Spoils packets both ways.
    local_address : str
        Interface to send from.

    Raises
    ------
    BridgeError
        The address cannot be used.
    """

    def __init__(self, remote: Address, faults: LinkFaults, local_address: str = '') -> None:
        self.remote = remote
        self.n_sent = self.n_received = self.n_foreign = 0
        self._faults = faults
        self._queue: deque[bytes] = deque(maxlen=QUEUE_LENGTH)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((local_address, 0))
            self._peer = (socket.gethostbyname(remote[0]), remote[1])
        except OSError as error:
            self._socket.close()
            raise BridgeError(f'cannot be reached: {error.strerror}', where=remote) from error
        self._socket.setblocking(False)

    @property
    def n_queued(self) -> int:
        """Datagrams waiting: each is one cycle of delay."""
        return len(self._queue)

    @property
    def address(self) -> Address:
        """Where this end is."""
        address: Address = self._socket.getsockname()[:2]
        return address

    def send(self, data: bytes, now_s: float) -> None:
        """Send one datagram, as far as the faults let it."""
        for part in self._faults.robot.carry(data, now_s):
            try:
                self._socket.sendto(part, self.remote)
                self.n_sent += 1
            except OSError:
                # Nobody listens there; the controller does not mind.
                continue

    def receive(self, now_s: float) -> bytes | None:
        """Return the oldest queued datagram and take it off the queue."""
        while True:
            try:
                data, address = self._socket.recvfrom(LARGEST_BYTES)
            except BlockingIOError:
                break
            except OSError:
                continue
            if address != self._peer:
                self.n_foreign += 1
                continue
            self.n_received += 1
            self._queue.extend(self._faults.sensor.carry(data, now_s))
        self._queue.extend(self._faults.sensor.due(now_s))
        return self._queue.popleft() if self._queue else None

    def flush(self) -> None:
        """Forget what is queued, as a new session does."""
        while self.receive(0.0) is not None:
            pass

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()
