"""Many problems at once: on this machine's processors or on a Dask cluster, resumable, and no problem can take others down."""

from ._problems import Problem as Problem
from ._problems import expand as expand
from ._store import COLUMNS as COLUMNS
from ._sweep import Sweep as Sweep
from ._sweep import sweep as sweep
