"""From a scene to a certified motion: the field leads, closed forms choose the posture, the certificate decides."""

from ._plan import Plan as Plan
from ._plan import plan as plan
