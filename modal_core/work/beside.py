"""Work that goes on beside this process: one item after the other, in a process of its own."""

from collections.abc import Callable
import mmap
import multiprocessing
import os
import pickle
import socket
import struct
from types import TracebackType
from typing import Any, cast, Generic, TypeVar

from modal_core.errors import ModalAnalysisError
from modal_core.work.side_by_side import begin, ENDED_FROM_OUTSIDE, n_processors

Item = TypeVar('Item')
Result = TypeVar('Result')
ALIGNED = 64
"""Arrays begin at multiples of this many bytes, as numpy's own do."""
LENGTH = struct.Struct('<Q')


def can_work_beside() -> bool:
    """Tell whether there is a processor for it, and a way to hand arrays over."""
    return n_processors() > 1 and hasattr(os, 'memfd_create')


class Beside(Generic[Item, Result]):
    """Works on items in order, while this process goes on with something else.

    The process is forked: what ``work`` knows is there without being copied, and from then on
    what it remembers is known there alone.  Items and results are handed over in shared memory.
    It ends when this context does, or its parent.

    Parameters
    ----------
    work : callable
        Takes an item and returns its result; an error it raises is raised by :meth:`result`.
    """

    def __init__(self, work: Callable[[Item], Result]) -> None:
        self._here, there = socket.socketpair()
        fork = multiprocessing.get_context('fork')
        self._process = fork.Process(target=_serve, args=(work, there, self._here), daemon=True)
        self._process.start()
        there.close()

    def __enter__(self) -> 'Beside[Item, Result]':
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._here.close()
        # Nobody waits for work that is not wanted any more.
        self._process.kill()
        self._process.join()

    def put(self, item: Item) -> None:
        """Hand over an item; waits for nothing.

        Raises
        ------
        ModalAnalysisError
            The process was ended from outside.
        """
        try:
            _send(self._here, item)
        except OSError as error:
            raise _ended() from error

    def result(self) -> Result:
        """Return the result of the first item whose result was not asked for yet.

        Raises
        ------
        ModalAnalysisError
            The process was ended from outside.
        """
        try:
            result, error = _receive(self._here)
        except (OSError, EOFError) as gone:
            raise _ended() from gone
        if error is not None:
            raise error
        return cast(Result, result)


def _ended() -> ModalAnalysisError:
    return ModalAnalysisError(
        ENDED_FROM_OUTSIDE,
        found='one at work',
        advice='if memory ran out, restrict it to one processor: taskset -c 0',
    )


def _serve(work: Callable[[Any], Any], there: socket.socket, here: socket.socket) -> None:
    here.close()
    begin()
    while True:
        try:
            item = _receive(there)
        except EOFError:
            return
        try:
            answer: tuple[Any, Exception | None] = work(item), None
        except Exception as error:  # noqa: BLE001 - whatever it is, it is raised over there
            answer = None, error
        _send(there, answer)


def _send(way: socket.socket, value: object) -> None:
    """Send a value: its large arrays stay in memory that both processes see."""
    buffers: list[pickle.PickleBuffer] = []
    head = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    parts = [memoryview(head), *(buffer.raw() for buffer in buffers)]
    lengths = struct.pack(f'<{len(parts)}Q', *(part.nbytes for part in parts))
    memory = os.memfd_create('modal_core')
    try:
        with open(memory, 'wb', closefd=False) as file:
            for part in (memoryview(lengths), *parts):
                file.seek(-(-file.tell() // ALIGNED) * ALIGNED)
                file.write(part)
        socket.send_fds(way, [LENGTH.pack(len(parts))], [memory])
    finally:
        os.close(memory)


def _receive(way: socket.socket) -> Any:
    """Receive a value; its arrays live in the shared memory, which goes when they go.

    Raises
    ------
    EOFError
        Nobody sends any more.
    """
    message, memories, _, _ = socket.recv_fds(way, LENGTH.size, 1)
    if not memories:
        raise EOFError
    try:
        shared = memoryview(mmap.mmap(memories[0], 0))
    finally:
        os.close(memories[0])
    (n_parts,) = LENGTH.unpack(message)
    end = n_parts * LENGTH.size
    parts = []
    for length in struct.unpack(f'<{n_parts}Q', shared[:end]):
        first = -(-end // ALIGNED) * ALIGNED
        end = first + length
        parts.append(shared[first:end])
    return pickle.loads(parts[0], buffers=parts[1:])  # noqa: S301 - what this program sent
