"""PyTorch's threads sleep while they wait: spinning ones make tests many times slower where cores are shared."""

import os

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
