"""Rings of traffic and whole drives as environments, and evaluations of policies that advise a driver on them.

``make`` returns a ``gymnasium.Env``, ``make_vec`` a ``gymnasium.vector.VectorEnv``, ``make_parallel`` a ``pettingzoo.ParallelEnv``: rings
of the fast engine, or drives with vehicle physics and SUMO's traffic. ``evaluate`` returns a table of evaluation results. ``save_policy``
writes a file for drives and studies. ``read`` opens their recordings. Settings have the names, units and ranges of ``codrive train`` and
``codrive run``; ``settings`` lists them.
"""

import warnings

from codrive_sim._drive import DriveEnv
from codrive_sim._drive_vector import DriveVectorEnv
from codrive_sim._drives import Leaders
from codrive_sim._evaluate import evaluate, policies
from codrive_sim._namesake import namesake_remedy
from codrive_sim._open_drive import Lane
from codrive_sim._policy_file import RecurrentLayer, describe_policy, save_policy
from codrive_sim._read import DataSet, Recording, read
from codrive_sim._register import make, make_parallel, make_vec, register
from codrive_sim._ring import RingEnv, RingVectorEnv
from codrive_sim._settings import settings
from codrive_sim._traffic import Hold, Moment, Vehicles
from codrive_sim._traffic_env import TrafficEnv

__all__ = [
    "DataSet",
    "DriveEnv",
    "DriveVectorEnv",
    "Hold",
    "Lane",
    "Leaders",
    "Moment",
    "Recording",
    "RecurrentLayer",
    "RingEnv",
    "RingVectorEnv",
    "TrafficEnv",
    "Vehicles",
    "describe_policy",
    "evaluate",
    "make",
    "make_parallel",
    "make_vec",
    "policies",
    "read",
    "register",
    "save_policy",
    "settings",
]
__version__ = "0.1.0"

register()
_is_old_build, _remedy = namesake_remedy()
if _is_old_build:
    warnings.warn(_remedy, stacklevel=2)
