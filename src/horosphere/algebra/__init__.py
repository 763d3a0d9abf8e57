"""The algebra G(4,1): the general element `Multivector`, slow and obvious, and the base of every batched value."""

from ._basis import basis as basis
from ._batch import Batch as Batch
from ._multivector import Multivector as Multivector
