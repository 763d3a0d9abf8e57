"""What a result says in words."""

import numpy as np

from horosphere.viewer import bound


def test_a_lower_bound_is_never_written_larger_than_it_is():
    assert bound(0.03997, 1) == "39.9 mm" and bound(0.039966) == "39.96 mm" and bound(-0.00011, 1) == "-0.2 mm"
    for value in np.random.default_rng(7).uniform(-0.1, 1.0, 2000):
        for digits in (1, 2):
            written = float(bound(value, digits).removesuffix(" mm"))
            assert written <= 1e3 * value + 1e-6 and 1e3 * value - written < 1.001 * 10.0**-digits
    assert bound(0.0235, 1) == "23.5 mm" and bound(0.0678, 1) == "67.8 mm"  # what is exact stays
