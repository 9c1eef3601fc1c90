# SPDX-License-Identifier: BSD-3-Clause
"""Results of batches, and runs over many seeds in worker processes."""
import concurrent.futures as _futures
import json as _json
import multiprocessing as _multiprocessing
import pathlib as _pathlib
import sqlite3 as _sqlite3

from . import fly, load

__all__ = ["Rows", "fly_many", "read_batch"]


class Rows(list):
    """Rows as dicts; `to_frame` makes a pandas data frame of them."""

    def to_frame(self):
        import pandas
        return pandas.DataFrame(list(self))


def _metrics(summary):
    """The metrics of a summary by name; those of a vehicle as NAME.VEHICLE."""
    flat = dict(summary["metrics"]["run"])
    for vehicle, metrics in summary["metrics"]["vehicles"].items():
        flat.update((f"{name}.{vehicle}", value) for name, value in metrics.items())
    return flat


def _fly_one(source, changes):
    summary = fly(source, changes, threads=1)
    row = dict(changes)
    row.update(outcome=summary["outcome"], state_hash=summary["state_hash"], simulated_s=summary["simulated_s"])
    row.update(_metrics(summary))
    return row


def fly_many(source, runs, jobs=None):
    """Flies one run for each dict of changes in `runs`, such as {"seed": 3}; rows in their order, whatever the number of jobs.

    source: as of `load`, but no Scenario. A row has the changes, outcome, state_hash and the metrics. Modules written in
    Python are available in the workers if the main program imports or defines them above `if __name__ == "__main__"`.
    """
    runs = [dict(run) for run in runs]
    for run in runs:
        load(source, run)  # reports invalid scenarios before the first flight
    source = source if isinstance(source, dict) else str(source)
    with _futures.ProcessPoolExecutor(jobs, mp_context=_multiprocessing.get_context("spawn")) as pool:
        return Rows(pool.map(_fly_one, [source] * len(runs), runs))


class Batch:
    """Results of `swiftlet batch`: `episodes`, `metrics` and `parameters` as Rows, and `wide`, one row an episode."""

    def __init__(self, folder):
        path = _pathlib.Path(folder)
        path = path / "results.sqlite" if path.is_dir() else path
        if not path.is_file():
            raise FileNotFoundError(f"{path}: there are no results of a batch")
        with _sqlite3.connect(f"file:{path}?mode=ro", uri=True) as database:
            database.row_factory = _sqlite3.Row
            table = lambda query: Rows(dict(row) for row in database.execute(query))  # noqa: E731
            self.info = {row["key"]: row["value"] for row in database.execute("SELECT key, value FROM batch")}
            self.episodes = table("SELECT * FROM episodes ORDER BY episode")
            self.metrics = table("SELECT episode, name, vehicle, value, unit, text FROM metrics ORDER BY episode, position")
            self.parameters = table("SELECT * FROM parameters ORDER BY episode, name")
        database.close()

    @property
    def wide(self):
        """One row an episode: its parameters, and its metrics as NAME or NAME.VEHICLE."""
        rows = {row["episode"]: dict(row) for row in self.episodes}
        for parameter in self.parameters:
            rows[parameter["episode"]][parameter["name"]] = _number(parameter["value"])
        for metric in self.metrics:
            name = f"{metric['name']}.{metric['vehicle']}" if metric["vehicle"] else metric["name"]
            rows[metric["episode"]][name] = metric["text"] if metric["value"] is None else metric["value"]
        return Rows(rows.values())


def _number(text):
    try:
        return _json.loads(text)
    except ValueError:
        return text


def read_batch(folder):
    """Results of `swiftlet batch --out FOLDER`."""
    return Batch(folder)
