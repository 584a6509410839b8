"""Rings of traffic as environments, and evaluations of policies that advise a driver on them.

``make`` gives a ``gymnasium.Env``, ``make_vec`` a ``gymnasium.vector.VectorEnv`` over the fast engine, ``evaluate`` a table of how well a
policy drives. Settings have the names, units and ranges of ``codrive train``; ``settings`` lists them.
"""

from codrive._evaluate import evaluate, policies
from codrive._register import make, make_vec, register
from codrive._ring import RingEnv, RingVectorEnv
from codrive._settings import settings

__all__ = ["RingEnv", "RingVectorEnv", "evaluate", "make", "make_vec", "policies", "register", "settings"]
__version__ = "0.1.0"

register()
