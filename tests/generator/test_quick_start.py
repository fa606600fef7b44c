"""What a prompt needs is loaded without what it does not need: seconds of every start."""

import subprocess
import sys

PROGRAM = """
import sys
from generator.text.prompt import check_prompt
check_prompt("a person waves")
print(*sorted(name for name in sys.modules if name.partition(".")[0] in {"spacy", "torch"}))
from generator.text.encoder import TextEncoder
TextEncoder().encode_sentences(["a person waves"])
print(*sorted({"spacy", "sympy", "torch._dynamo", "torch._inductor"} & set(sys.modules)))
"""


def test_prompt_check_and_text_encoder_import_neither_parser_nor_compiler() -> None:
    finished = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert finished.stdout == "\n\n"
