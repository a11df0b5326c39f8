"""Robot Web Services by the digest client of the standard library."""

import http.cookiejar
import json
import urllib.error
import urllib.parse
import urllib.request


class WebClient:
    """A client that shares no code with the server."""

    def __init__(self, port, password='robotics'):
        self.base = f'http://127.0.0.1:{port}'
        accounts = urllib.request.HTTPPasswordMgrWithDefaultRealm()
        accounts.add_password(None, self.base, 'Default User', password)
        self.cookies = http.cookiejar.CookieJar()
        self.opener = urllib.request.build_opener(
            urllib.request.ProxyHandler({}),
            urllib.request.HTTPDigestAuthHandler(accounts),
            urllib.request.HTTPCookieProcessor(self.cookies),
        )

    def ask(self, method, path, data=None):
        if isinstance(data, dict):
            data = urllib.parse.urlencode(data).encode()
        request = urllib.request.Request(self.base + path, data, method=method)
        try:
            with self.opener.open(request, timeout=10) as answer:
                self.headers = answer.headers
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            self.headers = error.headers
            return error.code, error.read()

    def state(self, path):
        status, body = self.ask('GET', f'{path}?json=1')
        assert status == 200
        return json.loads(body)['_embedded']['_state'][0]
