# SPDX-License-Identifier: BSD-3-Clause
"""One experiment: its options, its table of published against ours, and the files it writes."""
import concurrent.futures
import csv
import fcntl
import hashlib
import io
import json
import math
import multiprocessing
import os
import pathlib
import signal
import sys
import time

import swiftlet

from . import published
from .tables import markdown, short_number, write_file


def _end_by_interrupt():
    """Ctrl-C ends a worker without a message; the experiment itself reports it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _call(work, arguments):
    return work(**arguments)


class Experiment:
    """name: key in published.csv; folder: where the experiment writes, created here.

    jobs: runs at a time; changes no result. repetitions: runs a case instead of the experiment's own number. quick: fewer samples or
    seeds, shorter flights. resume: reuse what an earlier attempt finished.
    """

    def __init__(self, name, doc, folder, *, jobs=1, repetitions=None, quick=False, resume=False, quiet=False):
        self.name, self.doc, self.folder = name, doc, pathlib.Path(folder)
        self.jobs, self.quick, self.resume, self.quiet = jobs, quick, resume, quiet
        self.rows, self.files = [], []
        self._repetitions, self._most_repetitions = repetitions, 0
        self._log = None
        self._shown = -math.inf  # when progress was last shown
        self.folder.mkdir(parents=True, exist_ok=True)

    # Runs

    def repetitions(self, full, quick):
        """Runs a case: the user's choice, else the experiment's number for this version."""
        count = self._repetitions or (quick if self.quick else full)
        self._most_repetitions = max(self._most_repetitions, count)
        return count

    def map(self, work, arguments, what="flights"):
        """[work(**a) for a in arguments], in `jobs` processes.

        work: a function of a module's top level; its arguments and its result consist of what JSON has. Each finished call is one line
        of flights.jsonl, from which --resume reads it, as long as arguments and revision are the same.
        """
        keys = [hashlib.sha256(json.dumps([work.__module__, work.__qualname__, swiftlet.git_revision, a], sort_keys=True).encode())
                .hexdigest()[:32] for a in arguments]
        finished = self._finished()
        missing = list(dict.fromkeys(key for key in keys if key not in finished))
        argument_of = dict(zip(keys, arguments))
        started = time.monotonic()
        with concurrent.futures.ProcessPoolExecutor(max(1, min(self.jobs, len(missing))),
                                                    multiprocessing.get_context("spawn"), _end_by_interrupt) as pool:
            futures = {pool.submit(_call, work, argument_of[key]): key for key in missing}
            try:
                for count, future in enumerate(concurrent.futures.as_completed(futures), len(set(keys)) - len(missing) + 1):
                    finished[futures[future]] = future.result()
                    self._keep(futures[future], future.result())
                    self._progress(f"{count} of {len(set(keys))} {what}", started)
            except BaseException:
                for worker in multiprocessing.active_children():
                    worker.terminate()
                raise
        return [finished[key] for key in keys]

    def fly(self, source, runs):
        """Flies a scenario once for each dict of changes, such as {"seed": 3, "duration_s": 60}. For each: outcome, simulated_s,
        state_hash and the metrics, those of a vehicle as NAME.VEHICLE."""
        return self.map(fly_one, [{"source": str(source), "changes": dict(run)} for run in runs])

    def close(self):
        """Closes flights.jsonl."""
        if self._log is not None:
            self._log.close()

    def _finished(self):
        """{key: result} of what is finished; opens flights.jsonl, which one experiment at a time may write."""
        if self._log is None:
            self._log = (self.folder / "flights.jsonl").open("a+", encoding="utf-8")
            try:
                fcntl.flock(self._log, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise BlockingIOError(f"{self.folder}: another run of {self.name} writes there; wait, or choose another --out") from None
            if not self.resume:
                self._log.truncate(0)
            self._log.seek(0)
            self._known = {}
            for line in self._log:
                try:
                    entry = json.loads(line)
                    self._known[entry["key"]] = entry["result"]
                except (ValueError, KeyError, TypeError):
                    continue  # foreign, or cut off when the experiment was killed
            self._log.write("\n" if self._log.tell() else "")  # after a line that was cut off
        return self._known

    def _keep(self, key, result):
        self._log.write(json.dumps({"key": key, "result": result}) + "\n")
        self._log.flush()

    def _progress(self, text, started):
        now = time.monotonic()
        if self.quiet or now - max(started, self._shown) < 2.0:
            return
        self._shown = now
        end = "\r" if sys.stderr.isatty() else "\n"
        print(f"  {self.name}: {text}, {now - started:.0f} s", end=end, file=sys.stderr, flush=True)

    # The table

    def published(self, what):
        """The published figure of the row `what`; KeyError where there is none."""
        figure = published.find(self.name, what)
        if figure is None:
            raise KeyError(f"published.csv has nothing for {self.name}: {what}")
        return figure

    def row(self, what, ours, verdict="other conditions", note="", *, value=math.nan, tolerance=""):
        """Any row. verdict: "reproduced", "better", "differs" or "other conditions"; rows without a published figure have none, and
        their tolerance, a limit of our own, is kept or missed."""
        figure = published.find(self.name, what)
        if figure is None and tolerance:
            tolerance += ": missed" if verdict == "differs" else ": kept"
        self.rows.append({"what": what, "published": figure.text if figure else "-", "tolerance": tolerance, "ours": ours,
                          "verdict": verdict if figure else "no published figure", "note": note,
                          **({"value": value} if math.isfinite(value) else {})})

    def _compare(self, what, ours, digits, holds, note, tolerance):
        self.row(what, short_number(ours, digits), "reproduced" if holds else "differs", note, value=ours, tolerance=tolerance)

    def within(self, what, ours, tolerance, digits, note=""):
        """Reproduced when |ours - published| <= tolerance * |published|."""
        wanted = self.published(what).value
        self._compare(what, ours, digits, abs(ours - wanted) <= tolerance * abs(wanted), note, f"± {100 * tolerance:.3g} %")

    def at_most(self, what, ours, limit, digits, note=""):
        self._compare(what, ours, digits, ours <= limit, note, f"<= {limit:g}")

    def at_least(self, what, ours, limit, digits, note=""):
        self._compare(what, ours, digits, ours >= limit, note, f">= {limit:g}")

    def claim(self, what, ours, holds, note=""):
        """A statement that holds or does not; ours: text."""
        self.row(what, ours, "reproduced" if holds else "differs", note, tolerance="it holds")

    @property
    def missed(self):
        """Rows that differ from what was published, or miss a limit of our own."""
        return [row for row in self.rows if row["verdict"] == "differs" or row["tolerance"].endswith(": missed")]

    # Files

    def write_csv(self, file, columns, rows):
        """rows: sequences as long as `columns`; numbers as the shortest text that reads back as the same, NaN as an empty cell."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        for row in rows:
            if len(row) != len(columns):
                raise ValueError(f"{file}: expected {len(columns)} cells, found {row}")
            writer.writerow(["" if isinstance(cell, float) and math.isnan(cell) else cell for cell in row])
        write_file(self.folder / file, text.getvalue())
        self.files.append(file)

    def write_figure(self, file, figure):
        """A matplotlib figure as SVG, the same bytes for the same figure."""
        import matplotlib
        with matplotlib.rc_context({"svg.hashsalt": self.name, "svg.fonttype": "none"}):
            figure.savefig(self.folder / (file + ".part"), format="svg", metadata={"Date": None}, bbox_inches="tight")
        os.replace(self.folder / (file + ".part"), self.folder / file)
        self.files.append(file)

    def write_results(self):
        """result.json and result.md."""
        runs = self._most_repetitions
        result = {"experiment": self.name, "doc": self.doc, "version": swiftlet.__version__, "revision": swiftlet.git_revision,
                  "quick": self.quick, "repetitions": runs, "rows": self.rows, "files": self.files}
        write_file(self.folder / "result.json", json.dumps(result, indent=2, ensure_ascii=False) + "\n")
        made = f"Swiftlet {swiftlet.__version__} ({swiftlet.git_revision})" + (
            f", {runs} run{'s' if runs > 1 else ''} a case" if runs else "")
        title = self.name + (", quick version" if self.quick else "")
        figures = "".join(f"\n![{file}]({file})\n" for file in self.files if file.endswith(".svg"))
        write_file(self.folder / "result.md", f"# {title}\n\n{self.doc}\n\n{made}"
                   + ("; fewer and shorter than the full version" if self.quick else "") + f".\n\n{markdown(self.rows)}{figures}")


def fly_one(source, changes):
    """One flight to its end: outcome, simulated_s, state_hash and its metrics."""
    return result_of(swiftlet.fly(source, changes, threads=1))


def result_of(summary):
    """The parts of a summary that experiments use, flat: metrics of a vehicle are NAME.VEHICLE."""
    flat = {key: summary[key] for key in ("outcome", "simulated_s", "state_hash")}
    flat.update(summary["metrics"]["run"])
    for vehicle, metrics in summary["metrics"]["vehicles"].items():
        flat.update((f"{name}.{vehicle}", value) for name, value in metrics.items())
    return flat
