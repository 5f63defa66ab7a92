"""A chat model behind any server that is compatible with OpenAI's chat completions, by the package `openai`."""

from __future__ import annotations

import contextlib
import email.utils
import json
import math
import os
import time
from collections.abc import Callable, Mapping
from typing import Annotated, Any
from urllib.parse import urlsplit

from pydantic import Field

from physagent_jax.chat.base import Generation, Messages, ModelError, Schema
from physagent_jax.chat.completions import format_message, format_schema, read_completion
from physagent_jax.core.errors import UserError
from physagent_jax.core.packages import import_package
from physagent_jax.core.reading import shorten
from physagent_jax.core.strict import Seed, Strict

OWN_KEY, COMMON_KEY, ADDRESS = "PHYSAGENT_LLM_KEY", "OPENAI_API_KEY", "OPENAI_BASE_URL"
LONGEST_BODY = 4 * 2**20  # bytes of a server's answer that are read
LONGEST_WAIT = 60.0  # longest pause before another attempt that a server may ask for [s]
_FIRST_PAUSE, _LONGEST_PAUSE = 0.5, 8.0  # between attempts, doubled each time [s]
_LOOPBACK = ("localhost", "127.0.0.1", "::1")
_LEAST_SECRET = 8  # characters of a key: shorter ones are words that local servers are given for form's sake
_FORMAT_WORDS = ("response_format", "json_schema", "json_object", "schema", "grammar", "structured output")
_OPTIONAL = ("temperature", "seed")  # fields that a request can do without
_REJECTED, _BUSY = (400, 404, 415, 422, 501), (408, 409, 425, 429)
_ANY = 1000  # retries, as many as the options allow


class OpenAIOptions(Strict):
    """Options of the adapter `openai`.

    Attributes:
        model: Name of the model, as the server knows it.
        url: Address of the server's API, like "http://127.0.0.1:8000/v1"; None = that of the environment variable
            OPENAI_BASE_URL, or OpenAI's own.
        eyes: Whether the model takes pictures.
        timeout: Longest wait for one answer [s].
        retries: Attempts after the first one, where the server is busy or away; after a time-out at most one.
        max_tokens: Longest answer [tokens].
        temperature: Randomness of the answer; 0 = none.
        seed: Seed of that randomness; None = the server's choice.
    """

    model: Annotated[str, Field(min_length=1, max_length=300)]
    url: Annotated[str, Field(max_length=2_000)] | None = None
    eyes: bool = False
    timeout: float = Field(default=300.0, ge=0.01, le=3600)
    retries: int = Field(default=4, ge=0, le=20)
    max_tokens: int = Field(default=2_000, ge=1, le=1_000_000)
    temperature: float = Field(default=0.0, ge=0, le=2)
    seed: Seed | None = None


class OpenAIModel:
    """A model behind a server, with `OpenAIOptions`; ``sleep`` waits between attempts.

    What the server rejects by name (a schema, a temperature) is not sent again.
    """

    def __init__(self, **options: Any):
        self._options = OpenAIOptions(**options)
        openai, httpx = (
            import_package(name, "the chat model `openai`", "llm") for name in ("openai", "httpx2")
        )
        self.name, self.has_eyes = f"openai:{self._options.model}", self._options.eyes
        self.sleep: Callable[[float], None] = time.sleep
        self._openai, self._httpx = openai, httpx
        self._url = self._options.url or os.environ.get(ADDRESS)
        self._key = read_key(self._url)
        self._formats = [format_schema, lambda _: {"type": "json_object"}]  # the next one if one is rejected
        chosen = {"model", "temperature", "max_tokens", "seed"}
        self._fields = self._options.model_dump(include=chosen, exclude_none=True)
        self._deadline = math.inf
        address = urlsplit(self._url or "https:")
        http = openai.DefaultHttpxClient(
            event_hooks={"response": [self._receive]},
            timeout=self._options.timeout,
            verify=address.scheme == "https",  # else there are no certificates to load
            trust_env=address.hostname not in _LOOPBACK,  # a proxy sees nothing that stays on this machine
            follow_redirects=False,
        )
        self._client = openai.OpenAI(
            api_key=self._key or "none",
            base_url=self._url,
            max_retries=0,
            http_client=http,
            default_headers={"Accept-Encoding": "identity"},
        )

    def close(self) -> None:
        """Close the connections."""
        self._client.close()

    def generate(self, messages: Messages, schema: Schema | None = None) -> Generation:
        """Answer ``messages``; see `ChatModel`."""
        begun, failures, tried = time.monotonic(), (), 0
        while True:
            try:
                body = self._send(messages, schema)
                return self._read(body, time.monotonic() - begun, failures)
            except _Failure as each:
                failure = each
            failures += (str(failure),)
            if failure.rejected and self._leave_out(failure.rejected):
                continue
            pause = min(_FIRST_PAUSE * 2**tried, _LONGEST_PAUSE) if failure.wait is None else failure.wait
            tried += 1
            if tried > min(self._options.retries, failure.most_retries) or pause > LONGEST_WAIT:
                break
            self.sleep(pause)
        where = f" at {self._url}" if self._url else ""
        times = f" in {tried} attempts" if tried > 1 else ""
        raise ModelError(
            f"{self.name}{where} gave no answer{times}: {failure}",
            do=failure.do or "Check that the server runs and serves this model",
            latency_seconds=time.monotonic() - begun,
            failures=failures,
        )

    def _send(self, messages: Messages, schema: Schema | None) -> str:
        """One attempt: the text of the server's answer."""
        openai, fields = self._openai, dict(self._fields)
        if schema is not None and self._formats:
            fields["response_format"] = self._formats[0](schema)
        self._deadline = time.monotonic() + self._options.timeout
        ask = self._client.chat.completions.with_raw_response.create
        try:
            answer = ask(messages=[format_message(each) for each in messages], **fields)
            return answer.http_response.content.decode("utf-8", "replace")
        except openai.APITimeoutError:
            raise _Failure(f"no answer within {self._options.timeout:g} s", most_retries=1) from None
        except openai.APIConnectionError as error:
            if isinstance(error.__cause__, _Failure):
                raise error.__cause__ from None
            why = shorten(self._redact(str(error.__cause__ or error)))
            raise _Failure(f"the connection failed: {why}", most_retries=_ANY) from None
        except openai.APIStatusError as error:
            text = self._redact(error.response.text)
            raise _read_refusal(error.status_code, text, error.response.headers) from None
        except openai.OpenAIError as error:
            raise _Failure(f"the request failed: {shorten(self._redact(str(error)))}") from None

    def _receive(self, response: Any) -> None:
        """Receive an answer within bounds of bytes and time, before anything else reads it."""
        if response.headers.get("content-encoding", "identity") != "identity":
            raise _Failure("the server's answer is compressed, which was not asked for")
        body = bytearray()
        for block in response.stream:
            body += block
            if len(body) > LONGEST_BODY:
                raise _Failure(f"the server's answer has more than {LONGEST_BODY:,} bytes")
            if time.monotonic() > self._deadline:
                raise self._httpx.ReadTimeout("the answer took too long")
        response.stream.close()
        response.stream = self._httpx.ByteStream(bytes(body))

    def _read(self, body: str, seconds: float, failures: tuple[str, ...]) -> Generation:
        try:
            decoded = json.dumps(json.loads(body), ensure_ascii=False)  # a key may be spelt with escapes
            return read_completion(json.loads(self._redact(decoded)), self._options.model, seconds, failures)
        except (ValueError, RecursionError):
            shown = shorten(self._redact(body), 120) if body.strip() else "it is empty"
            raise _Failure(f"the server's answer is no whole chat completion ({shown})") from None

    def _leave_out(self, rejected: str) -> bool:
        """Leave out what a server's words reject, if a request can do without; return whether it can."""
        fields = self._fields
        named = next((name for name in _OPTIONAL if name in rejected and name in fields), None)
        if "max_completion_tokens" in rejected and "max_tokens" in fields:
            fields["max_completion_tokens"] = fields.pop("max_tokens")
        elif named:
            del fields[named]
        elif self._formats and any(word in rejected for word in _FORMAT_WORDS):
            self._formats.pop(0)
        else:
            return False
        return True

    def _redact(self, text: str) -> str:
        return text.replace(self._key, "[key]") if len(self._key) >= _LEAST_SECRET else text


class _Failure(Exception):
    """An attempt without an answer; its text holds no key.

    ``most_retries`` attempts are worth making after it, after the pause ``wait`` [s] if the server asks for one.
    ``rejected`` are the server's words, in lower case, where it rejects what was sent.
    """

    def __init__(self, what: str, *, most_retries: int = 0, wait: float | None = None, rejected="", do=""):
        super().__init__(what)
        self.most_retries, self.wait, self.rejected, self.do = most_retries, wait, rejected, do


def _read_refusal(status: int, text: str, headers: Mapping[str, str]) -> _Failure:
    """The failure that an HTTP status beyond 2xx stands for."""
    what = f"HTTP {status}" + (f": {shorten(' '.join(text.split()), 300)}" if text.strip() else "")
    if status in (401, 403):
        return _Failure(what, do=f"Set {OWN_KEY} or {COMMON_KEY} to a valid key")
    passing = (status in _BUSY or status >= 500) and "insufficient_quota" not in text
    wait, retries = (_read_wait(headers), _ANY) if passing else (None, 0)
    if wait is not None and wait > LONGEST_WAIT:
        what += f" (the server asks to wait {wait:g} s)"
    rejected = text.lower() if status in _REJECTED else ""
    return _Failure(what, most_retries=retries, wait=wait, rejected=rejected)


def _read_wait(headers: Mapping[str, str]) -> float | None:
    """Pause that a server asks for by Retry-After, in seconds or as a date [s]; None if it asks for none."""
    text = headers.get("retry-after", "")
    with contextlib.suppress(ValueError):
        return None if math.isnan(float(text)) else max(0.0, float(text))
    with contextlib.suppress(ValueError, TypeError):
        return max(0.0, email.utils.parsedate_to_datetime(text).timestamp() - time.time())
    return None


def read_key(url: str | None) -> str:
    """The key of the environment, "" without one; OpenAI's own variable only for https and this machine.

    Raises:
        UserError: The address is none or holds a secret, or the key has characters that no header can have.
    """
    try:
        parts = urlsplit(url or "https://default")
        usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        parts, usable = urlsplit(""), False
    if parts.username or parts.password or parts.query:
        raise UserError("a server's address holds a password or a query", do=f"Put the key into {OWN_KEY}")
    if not usable:
        do = "Give one like http://127.0.0.1:8000/v1"
        raise UserError("a server's address cannot be used", got=shorten(url, 80), do=do)
    trusted = parts.scheme == "https" or parts.hostname in _LOOPBACK
    key = (os.environ.get(OWN_KEY) or (os.environ.get(COMMON_KEY, "") if trusted else "")).strip()
    if not key.isascii() or not key.isprintable() or " " in key:
        raise UserError("the key in the environment has characters that no key can have", do="Set it anew")
    return key
