"""What holds for the whole suite."""

from __future__ import annotations

import os

# workers share the cores: threads of a linear algebra in each of them wait for one another, and a diagnosis takes several times
# as long; numpy and scipy ask for it when they are loaded, here and in the processes that tests start
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
