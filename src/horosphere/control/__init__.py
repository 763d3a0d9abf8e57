"""Following a field of directions with real dynamics: sliding modes, speed profiles, the unicycle; the live loop of an arm."""

from ._reactive import Reactive as Reactive
from ._reactive import Step as Step
from ._sliding import SlidingMode as SlidingMode
from ._speed import SpeedProfile as SpeedProfile
from ._track import PointMass as PointMass
from ._track import Track as Track
from ._track import track as track
from ._track import tracking_inflation as tracking_inflation
from ._unicycle import Drive as Drive
from ._unicycle import Unicycle as Unicycle
from ._unicycle import drive as drive
