"""A small web server that shows a study's page and stores the votes that come back."""

from __future__ import annotations

import json
import threading
from collections import Counter
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.study.schema import BALLOT_BYTES, PAGE, VOTES, Ballot, Study, read_ballot, read_study


class VoteStore:
    """Ballots in a study's folder, a file per participant; a later one may only add to an earlier one."""

    def __init__(self, folder: Path, study: Study):
        self.folder, self.study = folder / VOTES, study
        self._lock = threading.Lock()
        self._dealt: Counter[int] = Counter(
            int(path.name[:3]) for path in self.folder.glob("[0-9][0-9][0-9]-*.json")
        )

    def deal(self) -> int:
        """The sheet that the fewest participants of an open study were given."""
        with self._lock:
            sheet = min(range(len(self.study.sheets)), key=lambda index: self._dealt[index])
            self._dealt[sheet] += 1
            return sheet

    def add(self, data: bytes) -> Ballot:
        """Check and store a ballot.

        Raises:
            UserError: It is no ballot of this study, or contradicts what the participant has sent before.
        """
        ballot = read_ballot(data, self.study, "what was sent")
        path = self.folder / f"{ballot.code}.json"
        with self._lock:
            if path.exists():
                earlier = read_ballot(path.read_bytes(), self.study, path.name)
                if earlier.extends(ballot):
                    return earlier
                if not ballot.extends(earlier):
                    raise UserError(
                        "this code has voted already, and otherwise",
                        got=ballot.code,
                        do="The first votes count",
                    )
            write_text(path, ballot.model_dump_json() + "\n")
        return ballot


def make_server(folder: Path, host: str, port: int) -> ThreadingHTTPServer:
    """A server of the study in ``folder`` that does not run yet; port 0 takes a free one.

    Raises:
        UserError: There is no study, or the address cannot be used.
    """
    study = read_study(folder)
    store, page = VoteStore(folder, study), (folder / PAGE).read_bytes()

    class Handler(BaseHTTPRequestHandler):
        """Answers to three requests; no other file can be reached."""

        timeout = 60  # a connection that says nothing holds a thread no longer

        def do_GET(self) -> None:
            path = self.path.partition("?")[0]
            if path in ("/", "/index.html"):
                self._reply(200, "text/html; charset=utf-8", page)
            elif path == "/session":
                told = {"sheet": store.deal()} if study.open else {}
                self._reply(200, "application/json", json.dumps(told).encode())
            else:
                self._reply(404, "text/plain; charset=utf-8", b"There is no such page.")

        def do_POST(self) -> None:
            told = self.headers.get("Content-Length", "")
            if self.path != "/votes" or not told.isdecimal() or int(told) > BALLOT_BYTES:
                self.close_connection = True
                return self._reply(
                    400, "text/plain; charset=utf-8", b"Votes go to /votes, with their length."
                )
            try:
                store.add(self.rfile.read(int(told)))
            except UserError as error:
                return self._reply(400, "text/plain; charset=utf-8", str(error).encode())
            self._reply(200, "text/plain; charset=utf-8", b"stored")

        def _reply(self, status: int, kind: str, content: bytes) -> None:
            self.send_response(status)
            headers = {"Content-Type": kind, "Content-Length": str(len(content)), "Cache-Control": "no-store"}
            headers |= {"X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer"}
            for name, value in headers.items():
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *arguments: object) -> None:
            """Keep no log: it would hold addresses."""

    try:
        return ThreadingHTTPServer((host, port), Handler)
    except (OSError, OverflowError) as error:
        raise UserError(
            f"cannot serve at {host}:{port}", got=error, do="Choose another --port or --host"
        ) from None
