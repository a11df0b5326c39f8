"""A headless Chromium driven over its debugging pipe: what a page logs, draws and answers."""

import base64
from collections.abc import Iterator
from contextlib import contextmanager, suppress
import json
import os
from pathlib import Path
import select
import shutil
import signal
import subprocess
import tempfile
import time
from typing import Any

NAMES = ('chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable')
ARGUMENTS = (
    '--headless=new',
    '--no-sandbox',
    '--disable-gpu',
    '--disable-quic',
    '--disable-dev-shm-usage',
    '--no-first-run',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--hide-scrollbars',
    '--remote-debugging-pipe',
)
LONGEST_WAIT_S = 60.0


def find_browser() -> str | None:
    """Return the browser's path, or None."""
    return next((path for path in map(shutil.which, NAMES) if path), None)


class Page:
    """One tab; collects console messages, exceptions, violations and requests."""

    def __init__(self, write: int, read: int) -> None:
        self._write, self._read = write, read
        self._buffer = b''
        self._last = 0
        self._session: str | None = None
        self.problems: list[str] = []
        self.requests: list[str] = []
        self.loaded = False
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self._session = self.call('Target.attachToTarget', targetId=target, flatten=True)[
            'sessionId'
        ]
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(f'{domain}.enable')

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its answer."""
        self._last += 1
        message = {'id': self._last, 'method': method, 'params': parameters}
        if self._session:
            message['sessionId'] = self._session
        os.write(self._write, json.dumps(message).encode() + b'\0')
        wanted = self._last
        while True:
            answer = self._receive()
            if answer.get('id') == wanted:
                if 'error' in answer:
                    raise RuntimeError(f'{method}: {answer["error"]}')
                return answer['result']
            self._note(answer)

    def open(
        self,
        path: Path | str,
        *,
        width: int = 1280,
        dark: bool = False,
        reduced: bool = True,
        fragment: str = '',
    ) -> None:
        """Open a file or an address and wait until it is loaded and painted."""
        self.call(
            'Emulation.setDeviceMetricsOverride',
            width=width,
            height=900,
            deviceScaleFactor=1,
            mobile=width < 600,
        )
        self.call(
            'Emulation.setEmulatedMedia',
            features=[
                {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'},
                {
                    'name': 'prefers-reduced-motion',
                    'value': 'reduce' if reduced else 'no-preference',
                },
            ],
        )
        self.loaded = False
        url = path if isinstance(path, str) else path.resolve().as_uri()
        self.call('Page.navigate', url=url + fragment)
        while not self.loaded:
            self._note(self._receive())
        self.evaluate('new Promise((done) => requestAnimationFrame(() => setTimeout(done, 50)))')

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression; a promise is awaited."""
        result = self.call(
            'Runtime.evaluate', expression=expression, returnByValue=True, awaitPromise=True
        )
        if 'exceptionDetails' in result:
            raise RuntimeError(str(result['exceptionDetails']))
        return result['result'].get('value')

    def key(self, key: str) -> None:
        """Press and release a key."""
        for kind in ('keyDown', 'keyUp'):
            self.call(
                'Input.dispatchKeyEvent',
                type=kind,
                key=key,
                text=key if kind == 'keyDown' and len(key) == 1 else '',
            )

    def until(self, expression: str, timeout_s: float = 40.0) -> Any:
        """Wait until a JavaScript expression holds; return its value."""
        deadline = time.monotonic() + timeout_s
        while not (value := self.evaluate(expression)):
            if time.monotonic() > deadline:
                raise TimeoutError(expression, self.evaluate('document.body.innerText')[:2000])
            time.sleep(0.02)
        return value

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Send one mouse event: mouseMoved, mousePressed, mouseReleased."""
        self.call('Input.dispatchMouseEvent', type=kind, x=x, y=y, **more)

    def screenshot(self, path: Path, highest: int = 20_000) -> None:
        """Write the page as PNG, the whole of it or down to so many pixels."""
        height = min(highest, self.evaluate('document.documentElement.scrollHeight'))
        width = self.evaluate('document.documentElement.clientWidth')
        data = self.call(
            'Page.captureScreenshot',
            captureBeyondViewport=True,
            clip={'x': 0, 'y': 0, 'width': width, 'height': height, 'scale': 1},
        )['data']
        path.write_bytes(base64.b64decode(data))

    def pdf(self) -> bytes:
        """Return the page as it prints."""
        return base64.b64decode(self.call('Page.printToPDF', printBackground=True)['data'])

    def _receive(self) -> dict[str, Any]:
        deadline = time.monotonic() + LONGEST_WAIT_S
        while b'\0' not in self._buffer:
            left = deadline - time.monotonic()
            ready = left > 0 and select.select([self._read], [], [], left)[0]
            chunk = os.read(self._read, 1 << 20) if ready else b''
            if not chunk:
                raise TimeoutError('the browser does not answer')
            self._buffer += chunk
        line, self._buffer = self._buffer.split(b'\0', 1)
        return json.loads(line)

    def _note(self, event: dict[str, Any]) -> None:
        method, parameters = event.get('method'), event.get('params', {})
        if method == 'Page.loadEventFired':
            self.loaded = True
        elif method == 'Runtime.exceptionThrown':
            self.problems.append(str(parameters['exceptionDetails'])[:800])
        elif method == 'Runtime.consoleAPICalled' and parameters['type'] in ('error', 'warning'):
            self.problems.append(str(parameters['args'])[:800])
        elif method == 'Log.entryAdded' and parameters['entry']['level'] in ('error', 'warning'):
            self.problems.append(str(parameters['entry'])[:800])
        elif method == 'Page.javascriptDialogOpening':
            self.problems.append(f'dialogue: {parameters["message"]}')
            self._last += 1
            answer = {
                'id': self._last,
                'method': 'Page.handleJavaScriptDialog',
                'params': {'accept': False},
                'sessionId': self._session,
            }
            os.write(self._write, json.dumps(answer).encode() + b'\0')
        elif method == 'Network.requestWillBeSent':
            self.requests.append(parameters['request']['url'])


@contextmanager
def browser_page() -> Iterator[Page]:
    """Yield a page of a browser with a throw-away profile."""
    browser = find_browser()
    assert browser is not None
    to_browser, to_us = os.pipe(), os.pipe()

    def place_pipes() -> None:
        # Chromium reads commands on descriptor 3 and answers on 4.
        read, write = os.dup(to_browser[0]), os.dup(to_us[1])
        os.dup2(read, 3)
        os.dup2(write, 4)

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [browser, *ARGUMENTS, f'--user-data-dir={profile}'],
            preexec_fn=place_pipes,
            close_fds=False,
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser[0])
        os.close(to_us[1])
        try:
            yield Page(to_browser[1], to_us[0])
        finally:
            os.close(to_browser[1])
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait(timeout=20)
            os.close(to_us[0])
