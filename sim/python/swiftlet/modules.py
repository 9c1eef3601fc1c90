# SPDX-License-Identifier: BSD-3-Clause
"""Agents, guidance and detectors written in Python, which scenarios choose by name.

    @swiftlet.guidance("orbit", doc="circles around a point")
    class Orbit:
        center_m = swiftlet.key((0.0, 0.0, 3.0), "[m] center of the circle, world frame")
        radius_m = swiftlet.key(5.0, "[m] radius of the circle", min=0.1)

        def __init__(self, setup):       # setup: known to the vehicle before the start
            self.angle_rad = 0.0

        def step(self, now):             # once per tick
            ...
            return swiftlet.Goal(position_m, velocity_mps=v, yaw_rad=yaw)

A scenario selects it by `guidance: {type: orbit, radius_m: 4}`; misspelt keys are rejected. Every vehicle has its own object. An exception ends the run: its traceback comes out of `Simulator.tick` or `run`.
"""
import math as _math
import types as _types

from . import _core
from ._core import Command, Detection, Goal, StepInput, Cloud

__all__ = ["Cloud", "Command", "Detection", "Goal", "StepInput", "agent", "detector", "guidance", "key"]


class _Key:
    def __init__(self, default, doc, low, high, words):
        self.default, self.doc, self.low, self.high, self.words = default, doc, low, high, words


def key(default, doc, *, min=None, max=None, words=()):
    """A key that scenarios may set, as an attribute of a class.

    default: bool, int, float, str, a tuple of 3 numbers, or a list of numbers; its type is that of the key.
    doc: one line that begins with the unit in brackets, such as "[m] radius of the circle".
    words: of a text, the only ones that are allowed.
    """
    if not isinstance(doc, str):
        raise TypeError(f'doc: expected a text such as "[m] radius of the circle", found {doc!r}')
    if not doc.startswith("["):
        raise ValueError(f'the doc of a key begins with its unit in brackets, such as "[m] radius of the circle"; found "{doc}"')
    if isinstance(words, str) or not all(isinstance(word, str) for word in words):
        raise TypeError(f"words: expected a tuple of texts, found {words!r}")
    default = default.tolist() if hasattr(default, "tolist") else default  # numpy number or array
    if isinstance(default, str):
        if words and default not in words:
            raise ValueError(f"default: expected one of {', '.join(words)}, found {default}")
    elif not isinstance(default, bool):
        _check_numbers(default, min, max)
    return _Key(default, doc, min, max, list(words))


_INT = -2**31, 2**31 - 1  # limits of an int in C++


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _check_numbers(default, min, max):
    numbers = default if isinstance(default, (tuple, list)) else [default]
    if not all(_is_number(number) for number in numbers) or (isinstance(default, tuple) and len(default) != 3):
        raise TypeError("default: expected a bool, an int, a float, a text, a tuple of 3 numbers or a list of numbers, "
                        f"found {default!r}")
    low, high = _INT if isinstance(default, int) else (-_math.inf, _math.inf)
    low, high = (low if min is None else min), (high if max is None else max)
    if not (_is_number(low) and _is_number(high)):
        raise TypeError(f"min and max: expected numbers, found {min!r} and {max!r}")
    if not all(low <= number <= high for number in numbers):
        raise ValueError(f"default: expected numbers from {low} to {high}, found {default!r}")


def _register(kind, name, doc, clouds=False, map=False, relatives=False, world=True, true_pose=False, true_neighbors=False,
              detects=False):
    needs = dict(clouds=clouds, map=map, relatives=relatives, world=world, true_pose=true_pose, true_neighbors=true_neighbors,
                 detects=detects)

    if not isinstance(name, str):  # also when the decorator is used without a name
        raise TypeError(f'expected the name of the {kind}, such as @swiftlet.{kind}("mine"), found {name!r}')
    if not isinstance(doc, str):
        raise TypeError(f"doc: expected a text, found {doc!r}")
    for need, value in needs.items():
        if not isinstance(value, bool):
            raise TypeError(f"{need}: expected True or False, found {value!r}")

    def add(cls):
        if not isinstance(cls, type):
            raise TypeError(f"{kind} {name}: expected a class, found {cls!r}")
        if not callable(getattr(cls, "step", None)):
            raise TypeError(f"{cls.__name__}: expected a method step")
        keys = {}
        for base in reversed(cls.__mro__):
            keys.update((word, value) for word, value in vars(base).items() if isinstance(value, _Key))
        described = [(word, k.doc, k.default, k.low, k.high, k.words) for word, k in keys.items()]
        _core._add_class(kind, name, doc or (cls.__doc__ or name).strip().split("\n")[0], cls, described, needs)
        return cls

    return add


def guidance(name, *, doc="", clouds=False, map=False, relatives=False, world=True, true_pose=False,
             true_neighbors=False):
    """Makes a class the guidance `name`. Its step(now) returns a Goal, 3 numbers (a place in the world), or None: the last goal
    holds. clouds, map, relatives: required inputs of earlier stages. world=False: it needs no pose in
    the world. true_pose, true_neighbors: truth, by name."""
    return _register("guidance", name, doc, clouds=clouds, map=map, relatives=relatives, world=world, true_pose=true_pose,
                     true_neighbors=true_neighbors)


def detector(name, *, doc="", true_neighbors=False):
    """Makes a class the detector `name`, which the simulator scores. Its step(now) returns a list of Detection when it has
    finished a scan, also an empty one, and None otherwise."""
    return _register("detector", name, doc, clouds=True, true_neighbors=true_neighbors)


def agent(name, *, doc="", true_pose=False, true_neighbors=False, detects=False):
    """Makes a class the agent `name`: all software of a vehicle. Its step(now) returns rotor commands from 0 to 1 in the order of
    the airframe, a Command, or None: the last commands hold."""
    return _register("agent", name, doc, true_pose=true_pose, true_neighbors=true_neighbors, detects=detects)


def _make(cls, values, setup):
    """Called by C++ for every vehicle."""
    made = cls.__new__(cls)
    for word, value in values.items():
        setattr(made, word, value)
    setup["airframe"] = _types.SimpleNamespace(**setup["airframe"])
    if cls.__init__ is not object.__init__:
        made.__init__(_types.SimpleNamespace(**setup))
    return made
