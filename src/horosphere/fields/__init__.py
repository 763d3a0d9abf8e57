"""Harmonic fields in R^n: from anywhere to the goal around obstacles, with guarantees at any sampling period."""

from ._certificate import Check as Check
from ._certificate import FieldCertificate as FieldCertificate
from ._charge import safe_charge as safe_charge
from ._field import HarmonicField as HarmonicField
from ._path import Path as Path
from ._random_worlds import RandomWorld as RandomWorld
from ._random_worlds import random_world as random_world
