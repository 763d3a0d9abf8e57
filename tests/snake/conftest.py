import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(params=[1, 2], ids=lambda s: f"seed{s}")
def rng(request):
    return np.random.default_rng(request.param)
