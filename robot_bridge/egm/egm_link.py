"""The thread that answers the controller: one reply for each accepted packet, nothing else.

A blocking receive in a thread of its own, no executor and no queue in the loop.  A controller
reads one queued datagram per cycle, so a second reply to one packet would add a cycle of delay for
good.  So would replies to packets that piled up while this process stood still: those older than
the link's time-out, with newer ones behind them, count as missed.
"""

from collections.abc import Callable
from dataclasses import dataclass
import errno
import math
import select
import socket
import struct
import threading
import time

from modal_core.errors import BridgeError, MessageError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.work.real_time import ask_for_real_time
from robot_bridge.egm.egm_command import encode_sensor
from robot_bridge.egm.egm_feedback import decode_robot, RobotFeedback
from robot_bridge.egm.reply_latency import ReplyLatency
from robot_bridge.egm.session_check import Judgement, SessionCheck, Verdict
from robot_bridge.player import Reference

Address = tuple[str, int]
SO_TIMESTAMPNS = 35  # Linux; Python has no name for it
TIMESPEC = struct.Struct('@ll')
LARGEST_BYTES = 2048
REAL_TIME_PRIORITY = 20


@dataclass(frozen=True, slots=True)
class Packet:
    """One datagram, for the log.

    Parameters
    ----------
    sent : bool
        From us; else from the controller.
    time_ns : int [ns]
        Host clock.
    data : bytes
        As on the wire.
    verdict : str
        How it was judged: ``accept``, or why it was refused.
    """

    sent: bool
    time_ns: int
    data: bytes
    verdict: str


Answer = Callable[[RobotFeedback, Judgement, float, int], Reference | None]


class EgmLink:
    """Listens on one address and port and answers.

    Parameters
    ----------
    bind_address, port : str, int
        Where to listen; a wildcard address is refused.
    check : SessionCheck
        Judges packets.
    answer : callable
        ``(feedback, judgement, now_s, receipt_ns)`` to a reference, or None to stay silent.
    alarm : callable
        Told why when a packet is alarming.
    idle : callable
        Called with the time [s] at least every ``poll_s``, for watchdogs.
    log : callable or None
        Given every datagram both ways.
    stale_s : float [s]
        Older packets are not answered when newer ones wait.
    poll_s : float [s]
        Longest wait for a packet.

    Attributes
    ----------
    refusal, last_refusal : str
        Why the packets since the last accepted one are refused, and any was last; empty for none.

    Raises
    ------
    BridgeError
        The address is a wildcard, or cannot be bound.
    """

    def __init__(
        self,
        bind_address: str,
        port: int,
        check: SessionCheck,
        answer: Answer,
        alarm: Callable[[str], None],
        idle: Callable[[float], None],
        log: Callable[[Packet], None] | None = None,
        stale_s: float = math.inf,
        poll_s: float = 0.004,
    ) -> None:
        self.check = check
        self.latency = ReplyLatency()
        self.n_received = self.n_sent = 0
        self.failure = self.last_refusal = self.refusal = ''
        self.real_time = False
        self._answer, self._alarm, self._idle, self._log = answer, alarm, idle, log
        self._stale_s = stale_s
        self._seqno = 0
        self._closing = threading.Event()
        self._socket = bound_socket(bind_address, port)
        self._socket.settimeout(poll_s)
        self._newer = select.poll()
        self._newer.register(self._socket, select.POLLIN)
        self.address: Address = self._socket.getsockname()
        self._thread = threading.Thread(target=self._run, name='egm_link', daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def close(self) -> None:
        """Stop listening and give the port back."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)
        self._socket.close()

    def _run(self) -> None:
        self.real_time = ask_for_real_time(REAL_TIME_PRIORITY)
        while not self._closing.is_set():
            try:
                data, ancillary, _, address = self._socket.recvmsg(LARGEST_BYTES, 64)
            except TimeoutError:
                self._idle(time.monotonic())
                continue
            except OSError as error:
                if self._closing.is_set() or error.errno == errno.EBADF:
                    return
                if error.errno != errno.ECONNREFUSED:
                    self.failure = error.strerror or str(error)
                    self._alarm(f'receive failed: {self.failure}')
                continue
            self._take(data, address, receipt_ns(ancillary))

    def _take(self, data: bytes, address: Address, receipt_ns: int) -> None:
        now_s = time.monotonic()
        judgement = self.check.sender(address, now_s)
        feedback, refusal = None, ''
        if judgement.verdict == Verdict.ACCEPT and self._is_stale(receipt_ns):
            judgement = self.check.refuse_stale()
        elif judgement.verdict == Verdict.ACCEPT:
            try:
                feedback = decode_robot(data)
                judgement = self.check.feedback(feedback, address, now_s)
            except MessageError as error:
                refusal = str(error)
                judgement = self.check.refuse_content()
        if self._log is not None:
            label = judgement.reason or judgement.verdict.value
            self._log(Packet(False, receipt_ns, data, label))
        self._note(judgement, refusal)
        if judgement.verdict == Verdict.ALARM:
            self._alarm(f'{judgement.reason} {address[0]}:{address[1]}')
        elif feedback is not None and judgement.verdict != Verdict.IGNORE:
            self.n_received += 1
            if judgement.verdict == Verdict.NEW_SESSION:
                self._seqno = 0
            reference = self._answer(feedback, judgement, now_s, receipt_ns)
            if reference is not None:
                self._reply(reference, feedback.tm_ms, address, receipt_ns)

    def _note(self, judgement: Judgement, refusal: str) -> None:
        """Keep why the packets since the last accepted one are refused."""
        if judgement.verdict in (Verdict.ACCEPT, Verdict.NEW_SESSION):
            self.refusal = ''
        else:
            self.refusal = self.last_refusal = refusal or judgement.reason

    def _is_stale(self, receipt_ns: int) -> bool:
        old = (time.time_ns() - receipt_ns) / NANOSECONDS_PER_SECOND > self._stale_s
        return old and bool(self._newer.poll(0))

    def _reply(self, reference: Reference, tm_ms: int, address: Address, receipt_ns: int) -> None:
        data = encode_sensor(
            self._seqno, tm_ms, reference.position_deg.tolist(), reference.speed_deg_s.tolist()
        )
        try:
            self._socket.sendto(data, address)
        except OSError as error:
            self.failure = error.strerror or str(error)
            self._alarm(f'send failed: {self.failure}')
            return
        sent_ns = time.time_ns()
        self._seqno += 1
        self.n_sent += 1
        self.latency.add((sent_ns - receipt_ns) / NANOSECONDS_PER_SECOND)
        if self._log is not None:
            self._log(Packet(True, sent_ns, data, 'accept'))


def bound_socket(bind_address: str, port: int) -> socket.socket:
    """Return a datagram socket of one interface whose packets the kernel stamps as they come."""
    if bind_address in ('', '0.0.0.0', '::', '*'):  # noqa: S104
        raise BridgeError(
            'bind_address must name one interface',
            found=bind_address or 'nothing',
            advice='give the address of the network card the controller is connected to',
        )
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        link.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        link.bind((bind_address, port))
    except (OSError, OverflowError) as error:
        link.close()
        reason = getattr(error, 'strerror', None) or str(error)
        raise BridgeError(f'cannot listen: {reason}', where=f'{bind_address}:{port}') from error
    return link


def receipt_ns(ancillary: list[tuple[int, int, bytes]]) -> int:
    """Return when the kernel received a packet, by what came beside it [ns]."""
    for level, kind, data in ancillary:
        if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS:
            seconds, nanoseconds = TIMESPEC.unpack_from(data)
            return int(seconds * NANOSECONDS_PER_SECOND + nanoseconds)
    return time.time_ns()
