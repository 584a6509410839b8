"""Shared parts of the environments of all engines: spaces, seeds, and actions as the engines take them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from gymnasium.error import ClosedEnvironmentError, DependencyNotInstalled, ResetNeeded
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import Self

#: Upper limit of seeds, exclusive: the largest integer that a setting of codrive can hold.
SEEDS = 2**53

#: Messages for a step without a reset.
NEVER = "no episode has begun; call reset() first"
ENDED = "the episode has ended; call reset() first"


class RenderModeError(ValueError, TypeError):
    """A mode of drawing that an environment does not have. Stable-Baselines3 asks each environment for pictures, and goes on without them
    after a ``TypeError``."""


class RendererMissing(DependencyNotInstalled, TypeError):
    """The package was built without its renderer; a ``TypeError`` as ``RenderModeError`` is."""


def _remade(kind: type, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    return kind(*arguments, **named)


class Picklable:
    """Environment that is pickled, copied and sent to other processes as its arguments and its state, if an episode has begun."""

    _arguments: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *arguments: Any, **named: Any) -> Self:
        made = super().__new__(cls)
        made._arguments = (arguments, named)
        return made

    def get_state(self) -> dict[str, Any]:
        """Returns the state; every environment has its own."""
        raise NotImplementedError

    def set_state(self, state: dict[str, Any]) -> Any:
        """Sets a state of ``get_state``; every environment has its own."""
        raise NotImplementedError

    def __reduce__(self) -> tuple[Any, ...]:
        remade = (_remade, (type(self), *self._arguments))
        try:
            return (*remade, self.get_state())
        except (ResetNeeded, ClosedEnvironmentError):
            return remade

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.set_state(state)


class AdviceSettings(Protocol):
    """Observations and actions in the settings of each engine."""

    def inputs(self) -> list[tuple[str, float, float]]: ...
    @property
    def levels(self) -> int: ...
    @property
    def action_limits(self) -> tuple[float, float]: ...


class AdviceMeaning:
    """Meaning of an environment's numbers, from its ``settings``."""

    settings: AdviceSettings

    @property
    def inputs(self) -> list[tuple[str, float, float]]:
        """Returns the inputs of an observation: name, the value that becomes -1, and the value that becomes 1, SI units."""
        return self.settings.inputs()

    @property
    def action_limits(self) -> tuple[float, float]:
        """Returns the actions that -1 and 1 stand for, m/s2 or m/s."""
        return self.settings.action_limits


#: Attribute of an action space with the settings of its environment, JSON. Libraries keep the space in a model, also in its file.
MADE_WITH = "codrive_settings"


def spaces(settings: AdviceSettings, own: Space[Any] | None = None) -> tuple[Space[Any], Space[Any]]:
    """Returns the observation space and the action space of one vehicle; ``own`` is the user's observation space."""
    observation = own if own is not None else Box(-np.inf, np.inf, (len(settings.inputs()),), np.float32)
    action = Discrete(settings.levels) if settings.levels else Box(-1.0, 1.0, (1,), np.float32)
    setattr(action, MADE_WITH, getattr(settings, "learning", settings).json())
    return observation, action


def with_lane(advice: Space[Any]) -> Space[Any]:
    """Returns the action space with a lane beside the advice."""
    if isinstance(advice, Discrete):
        return MultiDiscrete(np.array([advice.n, 3]))
    return Box(-1.0, 1.0, (2,), np.float32)


def as_float32(actions: Any, levels: int, shape: tuple[int, ...], of: str = "") -> NDArray[np.float32]:
    """Returns actions of this shape as the engines take them, float32, flat; ``of`` names their owner in messages.

    Raises:
        TypeError: The actions are not numbers, or levels are not whole numbers.
        ValueError: The actions have another shape.
    """
    try:
        array = np.asarray(actions)
    except ValueError as fault:
        raise ValueError(f"actions{of} are not an array: {fault}; allowed: shape {shape}") from None
    if array.dtype.kind not in ("iu" if levels else "fiu"):
        allowed = "whole numbers" if levels else "numbers"
        raise TypeError(f"actions{of} are of dtype {array.dtype}; allowed: {allowed}, shape {shape}")
    if array.shape != shape:
        raise ValueError(f"actions{of} have shape {array.shape}; allowed: {shape}")
    if array.dtype == np.float32 and array.flags.c_contiguous:
        return array.reshape(-1)
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(array, dtype=np.float32).reshape(-1)


def check_actions(actions: NDArray[np.float32], levels: int, whose: Callable[[int], str]) -> None:
    """Refuses actions that are not finite or not levels. ``whose`` names the owner of an action by its place. For the few actions of drives a
    loop is faster than numpy.

    Raises:
        ValueError: An action is invalid.
    """
    values = actions.tolist()
    are_allowed = [0 <= value < levels if levels else math.isfinite(value) for value in values]
    if all(are_allowed):
        return
    first = are_allowed.index(False)
    given = f"{values[first]:.0f}" if levels else "NaN" if math.isnan(values[first]) else str(values[first])
    allowed = f"0 to {levels - 1}" if levels else "a finite number, -1 to 1 spans the limits"
    raise ValueError(f"the action{whose(first)} is {given}; allowed: {allowed}")


def checked_count(num_envs: Any, most: int) -> int:
    """Returns a checked number of environments.

    Raises:
        ValueError: The number is not allowed.
    """
    if isinstance(num_envs, bool) or not isinstance(num_envs, (int, np.integer)) or not 1 <= num_envs <= most:
        raise ValueError(f"num_envs is {num_envs!r}; allowed: a whole number from 1 to {most}")
    return int(num_envs)


def checked_mask(options: dict[str, Any] | None, num_envs: int) -> NDArray[np.bool_] | None:
    """Returns the mask of ``reset(options={"reset_mask": mask})``, if there is one.

    Raises:
        ValueError: The mask has another type or shape.
    """
    mask = (options or {}).get("reset_mask")
    if mask is None:
        return None
    mask = np.asarray(mask)
    if mask.dtype != np.bool_ or mask.shape != (num_envs,):
        raise ValueError(f"reset_mask is of dtype {mask.dtype} and shape {mask.shape}; allowed: bool, ({num_envs},)")
    return np.ascontiguousarray(mask)


def checked_seed(seed: Any) -> int:
    """Returns the checked seed of a ``reset``.

    Raises:
        ValueError: The seed is too large; larger ones would begin the episodes of smaller ones.
    """
    if not 0 <= int(seed) < SEEDS:
        raise ValueError(f"seed is {seed}; allowed: a whole number from 0 to {SEEDS - 1}")
    return int(seed)


def checked_vector_seed(seed: Any, how: str) -> None:
    """Refuses seeds of many environments that are not one whole number; ``how`` describes the seed of each in the message.

    Raises:
        TypeError: The seed is not a whole number.
    """
    if seed is not None and not isinstance(seed, (int, np.integer)):
        raise TypeError(f"seed is {seed!r}; allowed: one whole number, from which each {how}")


def vector_infos(values: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """Returns the infos of a vector environment in which each environment has all of these values, each ``(num_envs, ...)``."""
    everywhere = {f"_{name}": np.ones(len(value), np.bool_) for name, value in values.items()}
    return {**values, **everywhere}


def final_infos(ended: NDArray[np.bool_], final_observations: Any, values: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """Returns the infos of Gymnasium's vector environments for episodes that have just ended: their last observation and their info."""
    final_obs = np.full(len(ended), None, dtype=object)
    for number in np.flatnonzero(ended):
        final_obs[number] = final_observations[number].copy()
    final_info: dict[str, Any] = {}
    for name, value in values.items():
        final_info.update({name: np.where(ended, value, 0.0), f"_{name}": ended.copy()})
    return {"final_obs": final_obs, "_final_obs": ended.copy(), "final_info": final_info, "_final_info": ended.copy()}


def check_settings(given: str, own: str) -> None:
    """Refuses a state of an environment with other settings, both JSON.

    Raises:
        ValueError: The settings differ.
    """
    if given != own:
        mine, its = json.loads(own), json.loads(given)
        key = next((key for key in mine if mine[key] != its.get(key)), "set of settings")
        raise ValueError(f"the state is of an environment with another {key}; allowed: one with the same settings")


def check_open(is_closed: bool) -> None:
    """Refuses calls after ``close``.

    Raises:
        ClosedEnvironmentError: The environment is closed.
    """
    if is_closed:
        raise ClosedEnvironmentError("the environment is closed; make another")
