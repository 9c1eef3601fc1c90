# SPDX-License-Identifier: BSD-3-Clause
"""Swiftlet: a simulator of teams of UAVs that see with LiDAR.

    import swiftlet

    scenario = swiftlet.load("forest_patrol", {"vehicles[0].start.yaw_deg": 90}, seed=3)
    simulator = swiftlet.Simulator(scenario)
    while not simulator.finished:
        simulator.tick()
        print(simulator.t_s, simulator.states.position_m[0])
    print(simulator.summary()["metrics"])

docs/python.md explains it. Positions are in meters, world axes are east, north, up, times in seconds or integer nanoseconds.
"""
import collections.abc as _abc
import importlib.machinery as _machinery
import json as _json
import os as _os
import pathlib as _pathlib
import platform as _platform
import re as _re
import sys as _sys
import tempfile as _tempfile


def _explain():
    """Reason why this interpreter cannot import the compiled part, with a remedy; None: another reason."""
    here = _pathlib.Path(__file__).parent
    built = sorted(path.name for path in here.glob("_core.*.so"))
    this = f"{_platform.python_implementation()} {_platform.python_version()} ({_sys.executable})"
    if not built:
        return f"{here} has no compiled module; in a clone `tools/setup --python` builds it and prints the folder for PYTHONPATH"
    if not any("_core" + suffix in built for suffix in _machinery.EXTENSION_SUFFIXES):
        return (f"{here} is built for another Python ({', '.join(built)}), this is {this}. In a clone, `tools/build release "
                f"-DSWIFTLET_PYTHON=ON -DSWIFTLET_PYTHON_EXECUTABLE={_sys.executable} -- swiftlet_python` builds it for this one")
    try:
        import numpy  # noqa: F401
    except ImportError as numpy_error:
        return (f"expected numpy, which {this} does not have ({numpy_error}): install Debian's python3-numpy for /usr/bin/python3, "
                f"or `{_sys.executable} -m pip install numpy`")
    return None


try:
    from . import _core
except ImportError:
    _reason = _explain()
    if _reason is None:
        raise
    raise ImportError(f"swiftlet: {_reason}") from None
from ._core import (InputError, InternalError, Onboard, Scan, Scenario, Simulator, Table, Vehicle, World, allow_plugins, git_revision,
                    make_scan)
from .modules import Cloud, Command, Detection, Goal, StepInput, agent, detector, guidance, key

__version__ = _core.version
__all__ = ["Cloud", "Command", "Detection", "Goal", "InputError", "InternalError", "Onboard", "Scan", "Scenario", "Simulator",
           "StepInput", "Table", "Vehicle", "World", "agent", "allow_plugins", "check", "detector", "fly", "git_revision", "guidance", "key",
           "load", "make_scan"]

_PLAIN = _re.compile(r"[A-Za-z][\w./-]*")
_MEANS_MORE = {"true", "false", "yes", "no", "on", "off", "null", "nan", "inf"}


def _yaml(value):
    """A value in the syntax of a scenario."""
    if isinstance(value, str):
        return value if _PLAIN.fullmatch(value) and value.lower() not in _MEANS_MORE else _json.dumps(value)
    return _json.dumps(value, default=_plain)


def _plain(value):
    """Converts types that json lacks: arrays and numbers of numpy, and paths."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, _os.PathLike):
        return _os.fspath(value)
    raise TypeError(f"expected numbers, texts, lists and dicts, found {value!r}")


def _changes(changes, keys):
    if not isinstance(changes, (_abc.Mapping, type(None))):
        raise TypeError(f'changes: expected a dict such as {{"vehicles[0].start.yaw_deg": 90}}, found {changes!r}')
    for key in changes or ():
        if not isinstance(key, str):
            raise TypeError(f"changes: expected key paths, which are texts, found {key!r}")
    return [(key, _yaml(value)) for key, value in {**(changes or {}), **keys}.items()]


def load(source, changes=None, **keys):
    """Reads and checks a scenario.

    source: a path, the name of a scenario that comes with Swiftlet, a dict with the keys of a scenario, or a Scenario to be
    changed further.
    changes: by key path, such as {"vehicles[0].start.yaw_deg": 90}; keys: of the top level, such as seed=3.
    Raises InputError with file, line and key, as `swiftlet check` prints it.
    """
    if not isinstance(source, (str, _os.PathLike, dict, Scenario)):
        raise TypeError(f"source: expected a path, a name, a dict or a Scenario, found {source!r}")
    laid_on = _changes(changes, keys)
    if isinstance(source, dict):
        return _core._load_text(_json.dumps(source, default=_plain), "scenario", laid_on)
    return source._changed(laid_on) if isinstance(source, Scenario) else _core._load(source, laid_on)


def check(source, changes=None, **keys):
    """Checks a scenario: everything before the first tick of a run, without output. Raises InputError as `load` does."""
    with _tempfile.TemporaryDirectory() as folder:
        Simulator(load(source, changes, **keys), out=f"{folder}/run")


def _summary(self):
    """Summary of the run so far: the content of summary.json."""
    return _json.loads(self._summary_json())


def _to_frame(self):
    """The rows as a pandas data frame; a vector has a column for each component, such as position_m_0."""
    import pandas
    columns = {}
    for name in self.keys():
        values = self[name]
        if getattr(values, "ndim", 1) > 1:
            flat = values.reshape(len(values), -1)
            columns.update({f"{name}_{i}": flat[:, i].copy() for i in range(flat.shape[1])})
        else:
            columns[name] = values.copy() if hasattr(values, "copy") else values
    return pandas.DataFrame(columns)


Simulator.summary = _summary
Table.to_frame = _to_frame


def fly(source, changes=None, *, out=None, threads=0, watch=None, **keys):
    """Flies one run to its end and returns its summary.

    out: run directory, as of `swiftlet run --out`; None: nothing is written.
    watch: called as watch(simulator) after every tick.
    """
    if watch is not None and not callable(watch):
        raise TypeError(f"watch: expected a function of the simulator, found {watch!r}")
    simulator = Simulator(load(source, changes, **keys), threads=threads, out=out)
    if watch is None:
        simulator.run()
    else:
        while not simulator.finished:
            simulator.tick()
            watch(simulator)
    simulator.finish()
    return simulator.summary()


for _name in __all__:
    if isinstance(globals()[_name], type):
        globals()[_name].__module__ = __name__
from . import datasets, functions, results  # noqa: E402
from .results import fly_many, read_batch  # noqa: E402

__all__ += ["datasets", "fly_many", "functions", "read_batch", "results"]
