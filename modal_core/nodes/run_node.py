"""The life of a node's process: start, spin, stop quietly, say in one line what is wrong."""

import _thread
import atexit
from collections.abc import Callable, Iterator, Sequence
import contextlib
import faulthandler
import gc
import os
import signal
import sys
import threading
import time
from typing import TypeVar

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.utilities import get_default_context

from modal_core.errors import ModalAnalysisError
from modal_core.nodes.answered_requests_node import answer_all_requests
from modal_core.nodes.started_by import end_with_starter

InvalidHandleError = rclpy_implementation.InvalidHandle
RCLError = rclpy_implementation.RCLError
UnknownROSArgsError = rclpy_implementation.UnknownROSArgsError
EXIT_WELL, EXIT_FAULT, EXIT_BAD_SETTINGS = 0, 1, 2
# Fast DDS now and then waits for itself for ever when taken down (its issues 4026, 6193).
ENDING_S = 20
AGAIN_S = 0.01
"""Until a signal that Python dropped is raised once more; chosen: dropped again it comes again."""
AnyNode = TypeVar('AnyNode', bound=Node)


def run_node(
    name: str,
    make: Callable[[], AnyNode],
    spin: Callable[[AnyNode], None] = rclpy.spin,
    args: Sequence[str] | None = None,
) -> None:
    """Make a node and spin it until it is stopped.

    SIGINT and SIGTERM end it quietly, also while it is still starting; so does the end of a
    command that started it (``started_by``).  Taking it down may take
    ``ENDING_S``; after that the process ends with status 1 and says where it was stuck.

    Parameters
    ----------
    name : str
        Begins the line on the error channel.
    make : callable
        Makes the node; it may refuse its parameters.
    spin : callable
        Runs the node; returning, or the end of the context, ends the process.
    args : sequence of str or None
        Command line; None takes the process's own.

    Raises
    ------
    SystemExit
        Status 2, after one line: the user can put it right.
    """
    status = EXIT_FAULT
    atexit.register(lambda: _leave(status))
    # The last resort, which needs no interpreter: SIGALRM ends a process.
    atexit.register(signal.alarm, ENDING_S)
    # As Ctrl-C does, so that long work before the node spins ends too; rclpy calls both.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    sys.unraisablehook = _raised_in_vain
    node = None
    try:
        end_with_starter()
        with _quiet_once_stopped():
            _init(args)
            node = make()
            answer_all_requests(node)
            # Nor may a full collection hold up every thread for 60 ms while the node runs.
            gc.collect()
            gc.freeze()
            spin(node)
        status = EXIT_WELL
    except (KeyboardInterrupt, ExternalShutdownException):
        status = EXIT_WELL
    except (ModalAnalysisError, ParameterException, UnknownROSArgsError) as error:
        sys.stderr.write(f'{name}: {" ".join(str(error).split())}\n')
        status = EXIT_BAD_SETTINGS
        raise SystemExit(status) from error
    finally:
        _be_deaf()
        # Not a thread: what is stuck may hold the interpreter's lock.
        faulthandler.dump_traceback_later(ENDING_S, exit=True)
        if node is not None:
            node.destroy_node()
        with contextlib.suppress(RCLError):
            # A signal's own thread may have done so since it asked.
            rclpy.try_shutdown()
        # And once more for its threads, which the interpreter waits for before all else.
        faulthandler.dump_traceback_later(ENDING_S, exit=True)


@contextlib.contextmanager
def _quiet_once_stopped() -> Iterator[None]:
    """Let pass what the middleware refuses once its context has ended: a signal ended it.

    Of its own, so that the signal's interrupt, which may come while this is asked, is answered
    by who answers interrupts.
    """
    try:
        yield
    except (RCLError, InvalidHandleError):
        if rclpy.ok():
            raise


def _raised_in_vain(dropped: 'sys.UnraisableHookArgs') -> None:
    """Raise a signal again that Python drops, in a weak reference's last call or ``__del__``."""
    if isinstance(dropped.exc_value, KeyboardInterrupt):
        # Not threading, whose own locks may be held here; the alarm has another use.
        _thread.start_new_thread(_raise_again, ())
    elif not _was_half_made(dropped):
        sys.__unraisablehook__(dropped)


def _was_half_made(dropped: 'sys.UnraisableHookArgs') -> bool:
    """Return whether an object's end misses what its making, cut off by a signal, never set."""
    ends = getattr(dropped.object, '__name__', '') == '__del__'
    return ends and isinstance(dropped.exc_value, AttributeError)


def _raise_again() -> None:
    time.sleep(AGAIN_S)
    main = threading.main_thread().ident
    if main is not None:
        # Not SIGINT, which what a shell starts in the background ignores.
        signal.pthread_kill(main, signal.SIGTERM)


def _be_deaf() -> None:
    """Take no more signals: what is being taken down is not left half way."""
    for number in (signal.SIGINT, signal.SIGTERM):
        done = False
        while not done:
            # A signal that has come meanwhile is answered here first.
            with contextlib.suppress(KeyboardInterrupt):
                signal.signal(number, lambda *_: None)
                done = True


def _leave(status: int) -> None:
    """End the process now that all is said and taken down.

    What would follow only gives back memory: the interpreter takes its modules apart, then the
    middleware's libraries themselves, while threads of theirs still run.  There a process that
    had done all its work ended now and then in a segmentation fault.
    """
    # The participant goes with the last that holds it, some of it in circles.  Its end tells the
    # others at once that this node is gone; else they wait for its lease to run out, and ask
    # services that nobody answers any more.
    get_default_context().destroy()
    gc.unfreeze()
    gc.collect()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(status)


def _init(args: Sequence[str] | None) -> None:
    try:
        rclpy.init(args=args)
    except RCLError as error:
        raise ModalAnalysisError('bad command line', found=error) from error
