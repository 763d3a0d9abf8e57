"""Files: trajectories (NPZ, CSV, MCAP), certificates and other results (JSON); every file is complete or not there."""

from .._atomic import output_folder as output_folder
from .._atomic import writing as writing
from .._atomic import writing_set as writing_set
from ._json import plain as plain
from ._json import save_json as save_json
from ._json import to_json as to_json
from ._trajectories import TRAJECTORY_ENDINGS as TRAJECTORY_ENDINGS
from ._trajectories import load_trajectory as load_trajectory
from ._trajectories import save_trajectory as save_trajectory
