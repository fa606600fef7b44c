"""What all tests share: threads that sleep while they wait, and property tests that a busy computer does not fail."""

import os

# Before anything loads PyTorch: spinning threads make tests many times slower where cores are shared.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

from hypothesis import HealthCheck, settings

settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")
