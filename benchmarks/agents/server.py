"""A server on loopback that answers chat completions as it is told, well or badly."""

from __future__ import annotations

import dataclasses
import json
import socket
import struct
import threading
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Literal


@dataclasses.dataclass(frozen=True)
class Answer:
    """One HTTP answer.

    Attributes:
        body: The bytes that are sent.
        status: HTTP status.
        headers: Headers beside those of the length and the type.
        announced: Content-Length that is sent; None = the true one.
        manner: "whole"; "half": the connection closes in the middle of the body; "reset": it is reset before anything
            is sent; "silent": nothing is sent until the client goes; "drip": byte by byte.
    """

    body: bytes = b""
    status: int = 200
    headers: tuple[tuple[str, str], ...] = ()
    announced: int | None = None
    manner: Literal["whole", "half", "reset", "silent", "drip"] = "whole"


def complete(text: Any, **changes: Any) -> Answer:
    """A chat completion with this content.

    Args:
        text: The content.
        changes: Fields of the completion that are other than usual; None = left out.
    """
    choice = {"index": 0, "finish_reason": "stop", "message": {"role": "assistant", "content": text}}
    usage = {"prompt_tokens": 11, "completion_tokens": 7, "total_tokens": 18}
    fields = {"id": "1", "object": "chat.completion", "created": 1, "model": "scripted"}
    body = {**fields, "choices": [choice], "usage": usage, **changes}
    return Answer(json.dumps({key: each for key, each in body.items() if each is not None}).encode())


class ScriptedServer:
    """A server that asks ``reply`` for each answer; a context manager.

    Args:
        reply: Maker of the answer to a request, from its decoded body and its number, from 0.

    Attributes:
        requests: Bodies of the requests so far.
        headers: Their headers.
    """

    def __init__(self, reply: Callable[[dict[str, Any], int], Answer]):
        self.requests: list[dict[str, Any]] = []
        self.headers: list[Mapping[str, str]] = []
        self._stopping = threading.Event()
        self._server = _Server(("127.0.0.1", 0), _make_handler(self, reply))
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,), name="scripted")

    @property
    def url(self) -> str:
        """Address of the API."""
        return f"http://127.0.0.1:{self._server.server_address[1]}/v1"

    def __enter__(self) -> ScriptedServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopping.set()
        self._server.shutdown()
        self._server.server_close()  # waits for the threads of requests
        self._thread.join()

    def wait(self, connection: socket.socket) -> None:
        """Wait until the client has gone or the server stops."""
        connection.settimeout(0.02)
        while not self._stopping.is_set():
            try:
                if connection.recv(1) == b"":
                    return
            except TimeoutError:
                continue
            except OSError:
                return


class _Server(ThreadingHTTPServer):
    daemon_threads = False

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of clients that went in the middle of an answer."""


def _make_handler(server: ScriptedServer, reply: Callable[[dict[str, Any], int], Answer]) -> type:
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"
        timeout = 5

        def do_POST(self) -> None:
            size = int(self.headers.get("Content-Length", 0))
            body = json.loads(self.rfile.read(size))
            server.requests.append(body)
            server.headers.append(dict(self.headers.items()))
            self._send(reply(body, len(server.requests) - 1))

        def _send(self, answer: Answer) -> None:
            self.close_connection = True
            if answer.manner == "reset":  # lingering for 0 s closes with a reset
                self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                return
            if answer.manner == "silent":
                server.wait(self.connection)
                return
            self.send_response(answer.status)
            size = len(answer.body) if answer.announced is None else answer.announced
            for name, value in (
                ("Content-Type", "application/json"),
                ("Content-Length", str(size)),
                *answer.headers,
            ):
                self.send_header(name, value)
            self.send_header("Connection", "close")
            self.end_headers()
            if answer.manner == "drip":
                for byte in answer.body:
                    self.wfile.write(bytes([byte]))
                    if server._stopping.wait(0.02):
                        return
            sent = answer.body[: len(answer.body) // 2] if answer.manner == "half" else answer.body
            self.wfile.write(b"" if answer.manner == "drip" else sent)

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing."""

    return Handler
