"""HTTP/1.1 to one daemon: kept-alive connections, retries where a retry is safe, problems as exceptions."""
from __future__ import annotations

import http.client
import json
import random
import socket
import ssl
import threading
import time
import urllib.parse
import uuid
from typing import Any, Iterator

from .errors import AlderError, Busy, Unreachable, from_problem


class Answer:
    def __init__(self, status: int, headers: Any, body: bytes):
        self.status, self.headers, self.body = status, headers, body

    def json(self) -> Any:
        return json.loads(self.body)


class _UnixConnection(http.client.HTTPConnection):
    def __init__(self, path: str, timeout: float):
        super().__init__("localhost", timeout=timeout)
        self._path = path

    def connect(self) -> None:
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self._path)


class Transport:
    def __init__(self, url: str, token: str | None = None, timeout: float = 60.0, retries: int = 4):
        parts = urllib.parse.urlsplit(url if "//" in url else "http://" + url)
        if parts.scheme not in ("http", "https", "unix"):
            raise ValueError("%s: the address begins with http://, https:// or unix:" % url)
        self.url, self.token, self.timeout, self.retries = url.rstrip("/"), token, timeout, retries
        self._parts = parts
        self._lock = threading.Lock()
        self._idle: list[http.client.HTTPConnection] = []

    def _open(self, timeout: float) -> http.client.HTTPConnection:
        p = self._parts
        if p.scheme == "unix":
            return _UnixConnection(p.netloc + p.path, timeout)
        if p.scheme == "https":
            return http.client.HTTPSConnection(p.hostname or "", p.port, timeout=timeout, context=ssl.create_default_context())
        return http.client.HTTPConnection(p.hostname or "", p.port or 7420, timeout=timeout)

    def _headers(self, extra: dict[str, str] | None) -> dict[str, str]:
        headers = {"User-Agent": "alder-python/0.1.0", "Accept": "application/json"}
        if self.token:
            headers["Authorization"] = "Bearer " + self.token
        headers.update(extra or {})
        return headers

    def ask(self, method: str, path: str, body: Any = None, headers: dict[str, str] | None = None, timeout: float | None = None) -> Answer:
        """One request. A POST carries an idempotency key, so that it may be sent again; what failed for a passing reason (no
        connection, queue full, draining) is, with growing pauses. Anything else that is no success raises."""
        headers = self._headers(headers)
        if body is not None and not isinstance(body, (bytes, bytearray, memoryview)):
            body = json.dumps(body).encode()
            headers.setdefault("Content-Type", "application/json")
        if method == "POST":
            headers.setdefault("Idempotency-Key", '"%s"' % uuid.uuid4())
        error: AlderError | None = None
        for attempt in range(self.retries + 1):
            if attempt:
                pause = getattr(error, "retry_after", None) or 0.1 * 2 ** attempt
                time.sleep(min(pause, 10.0) * (1 + 0.2 * random.random()))
            try:
                answer = self._once(method, path, body, headers, timeout or self.timeout)
            except (ConnectionError, http.client.RemoteDisconnected, socket.gaierror, socket.timeout) as e:
                # Timeouts are not repeated: the daemon may be at work on it.
                error = Unreachable("%s: %s" % (self.url, e or type(e).__name__))
                if isinstance(e, (socket.timeout, socket.gaierror)):
                    break
                continue
            if answer.status < 400:
                return answer
            error = self.problem(answer)
            if not isinstance(error, Busy) or error.status == 507:
                raise error
        assert error is not None
        raise error

    def _once(self, method: str, path: str, body: Any, headers: dict[str, str], timeout: float) -> Answer:
        while True:
            with self._lock:
                connection = self._idle.pop() if self._idle else None
            fresh = connection is None
            if connection is None:
                connection = self._open(timeout)
            connection.timeout = timeout
            if connection.sock is not None:
                connection.sock.settimeout(timeout)
            try:
                connection.request(method, path, body=body, headers=headers)
                response = connection.getresponse()
                answer = Answer(response.status, response.headers, response.read())
            except (ConnectionError, http.client.HTTPException, OSError) as e:
                connection.close()
                # A connection that was idle may have been closed by the other side: once more on another one.
                if fresh or isinstance(e, socket.timeout):
                    raise
                continue
            if response.will_close:
                connection.close()
            else:
                with self._lock:
                    self._idle.append(connection)
            return answer

    @staticmethod
    def problem(answer: Answer) -> AlderError:
        try:
            problem = answer.json()
        except ValueError:
            problem = {"title": "HTTP %d" % answer.status, "detail": answer.body[:200].decode("utf-8", "replace")}
        after = answer.headers.get("Retry-After")
        return from_problem(answer.status, problem if isinstance(problem, dict) else {}, answer.headers.get("Alder-Request-Id"),
                            float(after) if after and after.replace(".", "", 1).isdigit() else None)

    def stream(self, path: str, headers: dict[str, str] | None = None, timeout: float = 30.0) -> "Stream":
        """A connection of its own whose body is read as it comes."""
        connection = self._open(timeout)
        try:
            connection.request("GET", path, headers=self._headers(headers))
            sock = connection.sock
            response = connection.getresponse()
        except OSError as e:
            connection.close()
            raise Unreachable("%s: %s" % (self.url, e)) from e
        if response.status >= 400:
            answer = Answer(response.status, response.headers, response.read())
            connection.close()
            raise self.problem(answer)
        return Stream(connection, response, sock)

    def close(self) -> None:
        with self._lock:
            idle, self._idle = self._idle, []
        for connection in idle:
            connection.close()


class Stream:
    def __init__(self, connection: http.client.HTTPConnection, response: http.client.HTTPResponse, sock: Any = None):
        self.connection, self.response, self._sock = connection, response, sock
        self.headers = response.headers

    def events(self) -> Iterator[tuple[str, Any, str | None]]:
        """Server-sent events: (event, data, id)."""
        event, data, ident = "message", [], None
        while True:
            raw = self.response.readline()
            if not raw:
                return
            text = raw.decode("utf-8").rstrip("\r\n")
            if not text:
                if data:
                    joined = "\n".join(data)
                    try:
                        yield event, json.loads(joined), ident
                    except ValueError:
                        yield event, joined, ident
                event, data = "message", []
                continue
            name, _, value = text.partition(":")
            value = value[1:] if value.startswith(" ") else value
            if name == "event":
                event = value
            elif name == "data":
                data.append(value)
            elif name == "id":
                ident = value

    def read_exactly(self, n: int) -> bytes:
        out = bytearray()
        while len(out) < n:
            try:
                piece = self.response.read(n - len(out))
            except http.client.HTTPException as e:   # cut off within a chunk
                raise EOFError from e
            if not piece:
                raise EOFError
            out += piece
        return bytes(out)

    def close(self) -> None:
        """From any thread: a read that waits in another one ends."""
        try:
            if self._sock is not None:
                self._sock.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass   # the other side was first
        self.connection.close()

    def __enter__(self) -> "Stream":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
