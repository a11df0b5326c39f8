"""A command in a real pseudo-terminal, and a person with a keyboard before it."""

import contextlib
import fcntl
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
import threading
import time

from test.support import held_key
from test.support.child import end_with_parent

ESCAPES = re.compile(r'\x1b\[[0-9;?]*[A-Za-z]')


class Terminal:
    """Runs a command whose standard input, output and error are one terminal."""

    def __init__(self, arguments, environment):
        self._mine, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack('HHHH', 50, 160, 0, 0))
        self.process = subprocess.Popen(
            arguments,
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env={**environment, 'TERM': 'xterm-256color'},
            preexec_fn=_own_terminal,
        )
        os.close(theirs)
        self.screen = ''
        self._lock = threading.Lock()
        self._finger = None
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        with contextlib.suppress(OSError):  # the other side has closed
            while data := os.read(self._mine, 65536):
                with self._lock:
                    self.screen += ESCAPES.sub('', data.decode(errors='replace'))

    def type(self, text):
        os.write(self._mine, text.encode())

    def hold(self, key=' '):
        """Press a key and keep it down: one stroke, a delay, then repeats."""
        self.let_go()
        # Isolated and without site packages: a finger is there at once.
        line = [sys.executable, '-I', '-S', held_key.__file__, str(self._mine), key]
        self._finger = subprocess.Popen(line, pass_fds=[self._mine], preexec_fn=end_with_parent)

    def let_go(self):
        """Let the key go; return when."""
        if self._finger is not None:
            self._finger.kill()
            self._finger.wait()
            self._finger = None
        return time.monotonic()

    def until(self, words, patience_s=60.0, after=0):
        """Wait until a text is on the screen beyond a place; return the place behind it."""
        deadline_s = time.monotonic() + patience_s
        while True:
            found = re.compile(words, re.DOTALL).search(self.screen, after)
            if found:
                return found.end()
            ended = self.process.poll() is not None
            assert not ended or not self._drained(), f'ended without {words!r}: {self.screen}'
            assert time.monotonic() < deadline_s, f'no {words!r} in: {self.screen[after:]}'
            time.sleep(0.02)

    def _drained(self):
        self._reader.join(1.0)
        return True

    def wait(self, patience_s=60.0):
        """Wait for the end of the command; return its status."""
        status = self.process.wait(patience_s)
        self._reader.join(2.0)
        return status

    def close(self):
        self.let_go()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
            self.process.wait()
        with contextlib.suppress(OSError):
            os.close(self._mine)


def _own_terminal():
    os.setsid()
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    signal.signal(signal.SIGINT, signal.default_int_handler)
