"""Rings of traffic as environments, and evaluations of policies that advise a driver on them.

``make`` gives a ``gymnasium.Env``, ``make_vec`` a ``gymnasium.vector.VectorEnv`` over the fast engine, ``evaluate`` a table of how well a
policy drives, ``save_policy`` a file that drives and studies take, ``read`` what they recorded. Settings have the names, units and
ranges of ``codrive train``; ``settings`` lists them.
"""

from codrive._evaluate import evaluate, policies
from codrive._policy_file import describe_policy, save_policy
from codrive._read import DataSet, Recording, read
from codrive._register import make, make_vec, register
from codrive._ring import RingEnv, RingVectorEnv
from codrive._settings import settings

__all__ = [
    "DataSet",
    "Recording",
    "RingEnv",
    "RingVectorEnv",
    "describe_policy",
    "evaluate",
    "make",
    "make_vec",
    "policies",
    "read",
    "register",
    "save_policy",
    "settings",
]
__version__ = "0.1.0"

register()
