"""Forward kinematics, Jacobians and inverse kinematics."""

from ._arcs import Arcs as Arcs
from ._arcs import elbow_arcs as elbow_arcs
from ._classify import Structure as Structure
from ._classify import classify as classify
from ._forward import carry as carry
from ._forward import forward as forward
from ._forward import frames as frames
from ._inverse import inverse as inverse
from ._jacobian import entity_jacobian as entity_jacobian
from ._jacobian import forward_and_jacobian as forward_and_jacobian
from ._jacobian import jacobian as jacobian
from ._jacobian import joint_generators as joint_generators
from ._numeric import numerical_inverse as numerical_inverse
from ._redundancy import limit_arcs as limit_arcs
from ._solutions import IkSolutions as IkSolutions
from ._targets import GripperOnPlane as GripperOnPlane
