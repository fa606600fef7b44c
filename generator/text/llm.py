"""Segments from a language model behind an OpenAI-compatible endpoint, in place of the splitter.

SegMo (Dang et al. 2026, section 3.3) segments with Qwen 3 8B under three rules: temporal order, details kept,
simultaneous actions in one segment. The wording of the instruction here is this project's own. Every answer is checked;
whatever is wrong with one, the splitter reads the prompt instead and a note says why.
"""

import json
import os
import re
from collections.abc import Callable
from typing import Any
from urllib.error import HTTPError, URLError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

from generator.config import MAX_ACTIONS
from generator.text.clauses import POSSESSIVES
from generator.text.prompt import check_prompt
from generator.text.reading import Reading, Segmenter
from generator.text.splitter import PERSON
from generator.text.wording import PEOPLE
from ros_free_stack.errors import InvalidOption

DEFAULT_MODEL = "qwen3:8b"
KEY_VARIABLE = "RFS_LLM_KEY"
TIMEOUT_S = 30.0
MAX_ANSWER_BYTES = 1_000_000
MAX_CHARACTERS = 200  # of one segment

INSTRUCTION = f"""\
You cut a description of human motion into segments, one for each step in time.

Rules:
1. Order. List the segments in the order in which they happen, whatever the order of the words. "Runs after walking" \
is walking first, then running.
2. Details. Keep every word that says how: side, body part, direction, number of repetitions, speed, style, \
"as if ...". Invent nothing. Leave out what is said not to happen.
3. Simultaneity. What happens at the same time is one segment, written with "while". "Is standing and waving" is one \
segment.
Squatting down and standing up again, or raising an arm and lowering it, is one segment too.

Form: at most {MAX_ACTIONS} segments. Each is lower case, has no full stop, begins with "{PERSON}" and a verb in the \
third person of the present, and says "the" for "his", "her", "their" or "your".
Answer with JSON alone: {{"segments": ["{PERSON} ...", "{PERSON} ..."]}}

Example: "Bow twice after you have waved with your left hand!"
{{"segments": ["{PERSON} waves with the left hand", "{PERSON} bows twice"]}}
Example: "a man is walking slowly while he claps, then stops"
{{"segments": ["{PERSON} walks slowly while clapping", "{PERSON} stops"]}}"""

_SCHEMA: dict[str, Any] = {
    "type": "object",
    "properties": {
        "segments": {"type": "array", "items": {"type": "string"}, "minItems": 1, "maxItems": MAX_ACTIONS},
    },
    "required": ["segments"],
    "additionalProperties": False,
}
_THINKING = re.compile(r"<think>.*?</think>", re.DOTALL)
_FENCED = re.compile(r"```(?:json)?\s*(.*?)```", re.DOTALL)
_SUBJECT = re.compile(rf"(?:(?:an?|the|this) )?(?:{'|'.join(sorted(PEOPLE))}) (?=[a-z])")
_POSSESSIVE = re.compile(rf"\b(?:{'|'.join(sorted(POSSESSIVES | {'her'}))}) (?=[a-z])")
_SEGMENT = re.compile(rf"{PERSON} (?:[a-z]+ly )?(?:[a-z]+s|has)\b[a-z0-9 ,'-]*")


class _BadAnswer(Exception):
    """Why an answer cannot be used."""


class LanguageModel:
    """Asks an endpoint for the segments; where that fails, the fall-back reads the prompt."""

    def __init__(
        self, url: str, model: str, fallback: Callable[[], Segmenter], *, timeout_s: float = TIMEOUT_S
    ) -> None:
        """Take the endpoint's base address, such as http://127.0.0.1:11434/v1; nothing is asked yet.

        The key that the environment variable RFS_LLM_KEY holds is sent along. `fallback` makes the other segmenter
        when it is first needed.

        Raises:
            InvalidOption: the address is not one of http or https.
        """
        parts = urlsplit(url)
        if parts.scheme not in {"http", "https"} or not parts.hostname:
            raise InvalidOption("--llm", f"expected an address such as http://127.0.0.1:11434/v1, found {url!r}")
        self._url, self._model, self._fallback, self._timeout_s = url.rstrip("/"), model, fallback, timeout_s

    def split(self, prompt: str) -> tuple[str, ...]:
        """The segment texts of a reading."""
        return self.read(prompt).segments

    def read(self, prompt: str) -> Reading:
        """One to five segment texts in temporal order, from the model or else from the fall-back.

        Raises:
            InvalidPrompt: the prompt is empty, too long or not English; or the fall-back refuses it.
        """
        text = check_prompt(prompt)
        try:
            return Reading(segments_of(self._ask(text)))
        except _BadAnswer as problem:
            reading = self._fallback().read(prompt)
            warning = f"warning: {self._model} at {self._url} was of no use ({problem}); the splitter read the prompt"
            return Reading(reading.segments, (warning, *reading.notes), reading.left_out, fell_back=True)

    def _ask(self, text: str) -> str:
        """The words that the model answers."""
        question = {
            "model": self._model,
            "temperature": 0,
            "messages": [{"role": "system", "content": INSTRUCTION}, {"role": "user", "content": text}],
            "response_format": {
                "type": "json_schema",
                "json_schema": {"name": "segments", "strict": True, "schema": _SCHEMA},
            },
        }
        answer = self._post(f"{self._url}/chat/completions", json.dumps(question).encode())
        try:
            content = json.loads(answer)["choices"][0]["message"]["content"]
        except (ValueError, LookupError, TypeError):
            raise _BadAnswer("the answer is no chat completion") from None
        if not isinstance(content, str) or not content.strip():
            raise _BadAnswer("the answer is empty")
        return content

    def _post(self, url: str, body: bytes) -> bytes:
        headers = {"Content-Type": "application/json"}
        if key := os.environ.get(KEY_VARIABLE):
            headers["Authorization"] = f"Bearer {key}"
        try:
            with urlopen(Request(url, body, headers), timeout=self._timeout_s) as response:
                return response.read(MAX_ANSWER_BYTES)
        except HTTPError as error:
            raise _BadAnswer(f"status {error.code}") from None
        except TimeoutError:
            raise _BadAnswer(f"no answer in {self._timeout_s:g} s") from None
        except URLError as error:
            timed_out = isinstance(error.reason, TimeoutError)
            raise _BadAnswer(f"no answer in {self._timeout_s:g} s" if timed_out else str(error.reason)) from None
        except (OSError, ValueError) as error:
            raise _BadAnswer(str(error)) from None


def segments_of(content: str) -> tuple[str, ...]:
    """The checked segment texts of a model's words: JSON, perhaps fenced: an object with "segments" or a bare list."""
    content = _THINKING.sub("", content).strip()
    fenced = _FENCED.search(content)
    try:
        found = json.loads(fenced.group(1) if fenced else content)
    except ValueError:
        raise _BadAnswer("the answer is not JSON") from None
    segments = found.get("segments") if isinstance(found, dict) else found
    if not isinstance(segments, list) or not all(isinstance(segment, str) for segment in segments):
        raise _BadAnswer("the answer is no list of texts")
    if not 1 <= len(segments) <= MAX_ACTIONS:
        raise _BadAnswer(f"{len(segments)} segments, expected 1 to {MAX_ACTIONS}")
    return tuple(_normalised(segment) for segment in segments)


def _normalised(segment: str) -> str:
    """A segment in the form that the models know: lower case, "a person" and a verb in the third person, no period."""
    text = " ".join(segment.lower().replace("’", "'").split()).strip(" .,;!")
    text = _POSSESSIVE.sub("the ", text)
    person = _SUBJECT.match(text)
    text = f"{PERSON} {text[person.end() :] if person else text}"
    if len(text) > MAX_CHARACTERS or not _SEGMENT.fullmatch(text):
        raise _BadAnswer(f"{segment[:60]!r} is not of the form '{PERSON} waves'")
    return text
