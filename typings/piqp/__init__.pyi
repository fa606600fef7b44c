from typing import Any

# The package is a compiled extension without type information: everything in it is Any.
def __getattr__(name: str) -> Any: ...
