"""Before anything loads PyTorch: its threads must not spin while they wait, or shared cores crawl."""

import os

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
