"""Drawing: the report as one offline HTML file, and what a result says in words."""

from ._live import LiveView as LiveView
from ._measure import Measures as Measures
from ._measure import measure as measure
from ._recording import has_viser as has_viser
from ._report import report_html as report_html
from ._robot_view import RobotView as RobotView
from ._robot_view import rest_posture as rest_posture
from ._robot_view import robot_html as robot_html
from ._summary import Summary as Summary
from ._summary import bound as bound
from ._summary import goal_error as goal_error
from ._summary import summarise as summarise
