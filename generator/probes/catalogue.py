"""All probes by action."""

from typing import Final

from generator.corpus.actions import ACTIONS
from generator.probes.spec import Probe

PROBES: Final[dict[str, Probe]] = {name: action.probe for name, action in ACTIONS.items()}
