"""Checks on arrays and small numerical helpers that every layer shares."""

from ._angles import wrap_angle as wrap_angle
from ._checks import file_path as file_path
from ._checks import float_array as float_array
from ._checks import is_number as is_number
from ._checks import number as number
from ._checks import whole_number as whole_number
from ._rotations import nearest_rotation as nearest_rotation
from ._rounded import at_least as at_least
from ._rounded import at_most as at_most
