"""The kernel compiler: a geometric expression, written once, becomes machine code for one element or a batch.

    @kernel(MOTOR, a=MOTOR, b=MOTOR)
    def motor_product(a, b):
        return a * b

See docs/kernels.md. What needs numba (`jit`, lanes) is imported when it is first asked for.
"""

from typing import Any

from ._blades import BIVECTOR as BIVECTOR
from ._blades import CIRCLE as CIRCLE
from ._blades import EUCLIDEAN as EUCLIDEAN
from ._blades import LINE as LINE
from ._blades import MOTOR as MOTOR
from ._blades import PAIR as PAIR
from ._blades import QUADVECTOR as QUADVECTOR
from ._blades import ROTOR as ROTOR
from ._blades import SCALAR as SCALAR
from ._blades import VECTOR as VECTOR
from ._blades import blade as blade
from ._blades import blades as blades
from ._cache import cache_folder as cache_folder
from ._cache import inner as inner
from ._cache import is_cache_writable as is_cache_writable
from ._cache import jit as jit
from ._cache import on_compile as on_compile
from ._functions import absolute as absolute
from ._functions import atan2 as atan2
from ._functions import atom as atom
from ._functions import floor as floor
from ._functions import maximum as maximum
from ._functions import minimum as minimum
from ._functions import polynomial as polynomial
from ._functions import round_even as round_even
from ._functions import sincos as sincos
from ._functions import sqrt as sqrt
from ._functions import where_lt as where_lt
from ._kernel import Kernel as Kernel
from ._kernel import kernel as kernel
from ._kernel import output_array as output_array
from ._multivector import E0 as E0
from ._multivector import E1 as E1
from ._multivector import E2 as E2
from ._multivector import E3 as E3
from ._multivector import EI as EI
from ._multivector import MV as MV
from ._multivector import PSEUDOSCALAR as PSEUDOSCALAR
from ._multivector import apply_motor as apply_motor
from ._trace import scalars as scalars

_NEED_NUMBA = frozenset(
    (
        *("ONE", "EIGHT", "spread", "load_records", "store_records", "load_lanes", "store_lanes"),
        *("load_columns", "store_columns", "call_compiled", "address_of"),
        *("min_lane", "max_lane", "sum_lanes"),
        *("lane_sqrt", "lane_abs", "lane_min", "lane_max", "lane_where_lt", "lane_mask_lt"),
    )
)


def __getattr__(name: str) -> Any:
    if name in _NEED_NUMBA:
        from numba import config

        from . import _calls, _lanes, _lanes_python

        if name in ("call_compiled", "address_of"):
            return getattr(_calls, name + ("_python" if config.DISABLE_JIT else ""))
        return getattr(_lanes_python if config.DISABLE_JIT else _lanes, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
