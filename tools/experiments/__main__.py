# SPDX-License-Identifier: BSD-3-Clause
"""Computes and flies published experiments again; tools/reproduce calls it. Each file of this folder is one experiment: its docstring
says what it shows, its function run(experiment) does it."""
import argparse
import ast
import difflib
import importlib
import os
import pathlib
import signal
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent


def experiments():
    """{name: docstring} of all experiments, without importing them."""
    files = (file for file in sorted(HERE.glob("*.py")) if not file.name.startswith("_"))
    return {file.stem.replace("_", "-"): ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) for file in files}


def arguments(known):
    parser = argparse.ArgumentParser(prog="tools/reproduce", description="Computes and flies published experiments again: data, figures and "
                                     "a table of published against ours.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="experiments; none: all of them")
    parser.add_argument("--out", default="reproduce", metavar="DIR", help="folder of the results, one folder each in it (reproduce)")
    parser.add_argument("--jobs", type=int, default=0, metavar="N", help="runs at a time, 0: as many as processors; changes no result")
    parser.add_argument("--repetitions", type=int, metavar="N", help="runs a case instead of the experiment's own number")
    parser.add_argument("--quick", action="store_true", help="a small version of each: fewer samples and seeds")
    parser.add_argument("--resume", action="store_true", help="do not run again what an earlier attempt finished")
    parser.add_argument("--list", action="store_true", help="only list the experiments")
    parser.add_argument("--write-docs", action="store_true", help="write the full results of DIR, of all experiments or "
                        "those named, to docs/results, and run nothing")
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    chosen = parser.parse_args()
    for name in chosen.names:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            parser.error(f"{name}: expected one of {', '.join(known)}" + (f'; did you mean "{near[0]}"?' if near else ""))
    for option in ("jobs", "repetitions"):
        if (getattr(chosen, option) or 0) < 0 or getattr(chosen, option) == 0 and option == "repetitions":
            parser.error(f"--{option}: expected a positive number, found {getattr(chosen, option)}")
    return chosen


def run(name, doc, options):
    """Runs one experiment; returns it."""
    from shared.experiment import Experiment
    started = time.monotonic()
    experiment = Experiment(name, doc.splitlines()[0], pathlib.Path(options.out) / name, quick=options.quick, resume=options.resume,
                            jobs=options.jobs or len(os.sched_getaffinity(0)), repetitions=options.repetitions, quiet=options.quiet)
    importlib.import_module(name.replace("-", "_")).run(experiment)
    experiment.write_results()
    experiment.close()
    if not options.quiet:
        print(f"{name}{', quick version' if options.quick else ''} in {time.monotonic() - started:.0f} s, written to {experiment.folder}")
        print(f"  {'':<58} {'published':>14} {'ours':>14} {'tolerance':>16}  verdict")
        for row in experiment.rows:
            print(f"  {row['what']:<58} {row['published']:>14} {row['ours']:>14} {row['tolerance']:>16}  {row['verdict']}"
                  + (f": {row['note']}" if row["note"] else ""), flush=True)
    return experiment


def run_all(names, known, options):
    """Runs the experiments; returns how many rows differ from what was published."""
    return sum(row["verdict"] == "differs" for name in names for row in run(name, known[name], options).rows)


def main():
    known = experiments()
    options = arguments(known)
    if options.list:
        for name, doc in known.items():
            print(f"{name:<20} {doc.splitlines()[0]}")
        return 0
    if options.write_docs:
        from shared import pages
        return pages.write(pathlib.Path(options.out), {name: known[name] for name in options.names or known})
    import swiftlet
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # ends the workers as well
    try:
        differing = run_all(options.names or known, known, options)
    except (OSError, swiftlet.InputError) as error:
        print(f"tools/reproduce: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("tools/reproduce: interrupted; --resume goes on with what is finished", file=sys.stderr)
        return 130
    if differing and not options.quiet:
        print(f"{differing} result{'s differ' if differing > 1 else ' differs'} from what was published")
    return 0


if __name__ == "__main__":
    sys.exit(main())
