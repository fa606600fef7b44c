"""A language model's answers, good and bad, from a real server on this machine."""

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest

from generator.text.llm import KEY_VARIABLE, LanguageModel
from generator.text.reading import Reading
from ros_free_stack.errors import InvalidOption, InvalidPrompt

PROMPT = "bow twice after waving with your left hand"
GOOD = ("a person waves with the left hand", "a person bows twice")


class Fallback:
    """A segmenter whose answer no model gives."""

    def read(self, prompt: str) -> Reading:
        return Reading((f"a person falls back to {prompt}",), ("a note of its own",))

    def split(self, prompt: str) -> tuple[str, ...]:
        return self.read(prompt).segments


Answer = Callable[[dict[str, Any]], tuple[int, bytes]]


@contextmanager
def endpoint(answer: Answer) -> Iterator[tuple[str, list[tuple[str, dict[str, Any], dict[str, str]]]]]:
    """A server that answers every POST; yields its base address and the requests that it got."""
    requests: list[tuple[str, dict[str, Any], dict[str, str]]] = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            question = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            requests.append((self.path, question, dict(self.headers)))
            status, body = answer(question)
            try:
                self.send_response(status)
                self.end_headers()
                self.wfile.write(body)
            except OSError:
                pass  # the client gave up waiting

        def log_message(self, *_: Any) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/v1", requests
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def says(content: Any) -> Answer:
    body = json.dumps({"choices": [{"message": {"role": "assistant", "content": content}}]}).encode()
    return lambda _: (200, body)


def read(answer: Answer, timeout_s: float = 10.0) -> Reading:
    with endpoint(answer) as (url, _):
        return LanguageModel(url, "small", Fallback, timeout_s=timeout_s).read(PROMPT)


@pytest.mark.parametrize(
    "content",
    [
        json.dumps({"segments": GOOD}),
        json.dumps(GOOD),
        f"```json\n{json.dumps({'segments': GOOD}, indent=1)}\n```",
        f"<think>first bow, no: wave</think>\n{json.dumps({'segments': GOOD})}",
        json.dumps({"segments": ["The man waves with his left hand.", " A  person bows twice. "]}),
        json.dumps({"segments": ["waves with the left hand", "she bows twice"]}),
    ],
)
def test_good_answers_take_the_form_of_segments(content: str):
    assert read(says(content)) == Reading(GOOD)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ("first she waves, then she bows", "not JSON"),
        ('{"segments": ["a person waves"', "not JSON"),
        ('{"steps": ["a person waves"]}', "no list of texts"),
        ('{"segments": [1, 2]}', "no list of texts"),
        ('"a person waves"', "no list of texts"),
        ('{"segments": []}', "0 segments"),
        (json.dumps({"segments": ["a person waves"] * 21}), "21 segments, expected 1 to 20"),
        ('{"segments": ["a person waves", ""]}', "not of the form"),
        ('{"segments": ["a person wave"]}', "not of the form"),
        ('{"segments": ["一个人挥手"]}', "not of the form"),
        (json.dumps({"segments": ["a person waves " + "and waves " * 40]}), "not of the form"),
        ("  ", "empty"),
        (None, "empty"),
    ],
)
def test_bad_content_falls_back_with_one_warning(content: str | None, why: str):
    reading = read(says(content))
    assert reading.segments == (f"a person falls back to {PROMPT}",)
    assert reading.fell_back
    warning, own = reading.notes
    assert warning.startswith("warning: small at http://127.0.0.1:")
    assert why in warning and "\n" not in warning
    assert own == "a note of its own"


@pytest.mark.parametrize(
    ("status", "body", "why"),
    [
        (500, b"", "status 500"),
        (404, b"model not found", "status 404"),
        (200, b"", "no chat completion"),
        (200, b"<html></html>", "no chat completion"),
        (200, b"[]", "no chat completion"),
        (200, b'{"choices": []}', "no chat completion"),
    ],
)
def test_bad_replies_fall_back(status: int, body: bytes, why: str):
    reading = read(lambda _: (status, body))
    assert reading.fell_back
    assert why in reading.notes[0]


def test_late_answer_falls_back():
    def late(_: dict[str, Any]) -> tuple[int, bytes]:
        time.sleep(0.5)
        return 200, b""

    reading = read(late, timeout_s=0.1)
    assert reading.fell_back
    assert "no answer in 0.1 s" in reading.notes[0]


def test_refused_connection_falls_back():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    reading = LanguageModel(f"http://127.0.0.1:{port}/v1", "small", Fallback).read(PROMPT)
    assert reading.fell_back
    assert "refused" in reading.notes[0]


@pytest.mark.parametrize("key", [None, "secret"])
def test_what_is_asked(monkeypatch: pytest.MonkeyPatch, key: str | None):
    monkeypatch.delenv(KEY_VARIABLE, raising=False)
    if key is not None:
        monkeypatch.setenv(KEY_VARIABLE, key)
    with endpoint(says(json.dumps(GOOD))) as (url, requests):
        assert LanguageModel(f"{url}/", "small", Fallback).split(PROMPT) == GOOD
    ((path, question, headers),) = requests
    assert path == "/v1/chat/completions"
    assert question["model"] == "small"
    assert question["temperature"] == 0
    assert question["messages"][-1] == {"role": "user", "content": PROMPT}
    assert headers.get("Authorization") == (f"Bearer {key}" if key else None)


@pytest.mark.parametrize("url", ["", "127.0.0.1:11434", "file:///etc/hosts", "http://"])
def test_address_must_be_one(url: str):
    with pytest.raises(InvalidOption, match="--llm"):
        LanguageModel(url, "small", Fallback)


def test_hopeless_prompt_is_not_sent():
    with endpoint(says("")) as (url, requests), pytest.raises(InvalidPrompt):
        LanguageModel(url, "small", Fallback).read("   ")
    assert not requests
