# SPDX-License-Identifier: BSD-3-Clause
"""docs/results: one page of results for each document, from the result.json and the figures of full runs."""
import json
import pathlib
import re
import shutil
import sys

from .tables import markdown, write_file

DOCS = pathlib.Path(__file__).resolve().parent.parent.parent.parent / "docs"
PAGES = {  # citation: (page, title)
    "Vrba 2025": ("detection", "On Onboard LiDAR-based Flying Object Detection [Vrba 2025]"),
    "Pritzl 2024": ("guidance", "Drones Guiding Drones [Pritzl 2024]"),
    "Orsulic 2021": ("slam", "Flying with Cartographer [Orsulic 2021]"),
    "Kamler 2025": ("rbl", "Safe flocking with 3D LiDAR [Kamler 2025]"),
}
HEAD = """# {title}

Results of the experiments of [reproduction.md](../reproduction.md), which explains the verdicts. `tools/reproduce NAME` makes one again;
`tools/reproduce --write-docs` writes this page.
"""


def page_of(doc):
    """The page of an experiment, by the document that its first line cites."""
    return next(page for citation, page in PAGES.items() if citation in doc.splitlines()[0])


def section(doc, result):
    """The text of one experiment: explanation, table, figures, revision."""
    text = doc.split("\n", 1)[1].strip() if "\n" in doc else doc
    runs = result["repetitions"]
    figures = "".join(f"\n![{result['experiment']}](../images/reproduction/{file})\n" for file in result["files"] if file.endswith(".svg"))
    return (f"{text}\n\n{markdown(result['rows'])}{figures}\nSwiftlet {result['version']} ({result['revision']})"
            + (f", {runs} run{'s' if runs > 1 else ''} a case" if runs else "") + ".\n")


def sections_of(text):
    """{experiment: text below its heading}, in the order of the page."""
    parts = re.split(r"^## `([\w-]+)`\n", text, flags=re.M)[1:]
    return {name: body.strip() + "\n" for name, body in zip(parts[::2], parts[1::2])}


def write(results, known, docs=DOCS):
    """Writes the sections of all experiments with a full result in the folder `results`; others stay as they are. Returns 0, or 2
    when there is no result."""
    changed = {}
    for name, doc in known.items():
        file = results / name / "result.json"
        result = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {"quick": True}
        if result["quick"]:
            continue
        changed.setdefault(page_of(doc), {})[name] = section(doc, result)
        for figure in (figure for figure in result["files"] if figure.endswith(".svg")):
            shutil.copy(results / name / figure, docs / "images/reproduction" / figure)
    if not changed:
        print(f"tools/reproduce: expected {results}/NAME/result.json of a run without --quick, found none", file=sys.stderr)
        return 2
    for (page, title), sections in changed.items():
        path = docs / "results" / f"{page}.md"
        kept = sections_of(path.read_text(encoding="utf-8")) if path.exists() else {}
        bodies = "".join(f"\n## `{name}`\n\n{body}" for name, body in {**kept, **sections}.items())
        path.parent.mkdir(exist_ok=True)
        write_file(path, HEAD.format(title=title) + bodies)
        print(f"{path}: {', '.join(sections)}")
    return 0
