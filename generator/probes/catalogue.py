"""All probes by action."""

from generator.probes import arms, hands, legs, steps, trunk
from generator.probes.spec import Probe

PROBES: dict[str, Probe] = {
    probe.action: probe for family in (arms, hands, trunk, legs, steps) for probe in family.PROBES
}
