# SPDX-License-Identifier: BSD-3-Clause
"""docs/results: one page of results for each document, from the result.json and the figures of full runs, and the overview of
docs/reproduction.md, from these pages."""
import collections
import json
import pathlib
import re
import shutil
import sys

from .tables import markdown, read_markdown, write_file

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
BEGIN, END = "<!-- overview: written by tools/reproduce --write-docs -->\n", "<!-- end of overview -->"  # around the table


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


def sections_in(path):
    """The same of a file; none where it does not exist yet."""
    return sections_of(path.read_text(encoding="utf-8")) if path.exists() else {}


def overview(docs=DOCS):
    """The table of docs/reproduction.md: of each experiment its first published figure beside ours, and the number of verdicts."""
    lines = ["| experiment | figure | published | ours | verdicts of all its rows |", "| --- | --- | --- | --- | --- |"]
    for page, _ in PAGES.values():
        for name, text in sections_in(docs / "results" / f"{page}.md").items():
            rows = [row for table in read_markdown(text) for row in table if "verdict" in row and row["published"] != "-"]
            counts = collections.Counter(row["verdict"] for row in rows)
            if rows:
                lines.append(f"| [{name}](results/{page}.md#{name}) | {rows[0]['what']} | {rows[0]['published']} | {rows[0]['ours']} | "
                             + ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common()) + " |")
    return "".join(line + "\n" for line in lines)


def with_overview(text, docs=DOCS):
    """The text of docs/reproduction.md with its table of today."""
    before, _, rest = text.partition(BEGIN)
    return before + BEGIN + overview(docs) + END + rest.partition(END)[2]


def write(results, known, docs=DOCS):
    """Writes the sections of all known experiments with a full result in the folder `results`, and the overview; other sections stay
    as they are. Returns 0, or 2 when there is no result, or one of an uncommitted program."""
    changed, figures = {}, []
    for name, doc in known.items():
        file = results / name / "result.json"
        result = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {"quick": True}
        if result["quick"]:
            continue
        if not re.fullmatch("[0-9a-f]+", result["revision"]):
            print(f"tools/reproduce: {file}: expected results of a committed revision, found {result['revision']!r}; commit the changes, "
                  "build and fly it again", file=sys.stderr)
            return 2
        changed.setdefault(page_of(doc), {})[name] = section(doc, result)
        figures += [results / name / figure for figure in result["files"] if figure.endswith(".svg")]
    if not changed:
        print(f"tools/reproduce: expected {results}/NAME/result.json of a run without --quick, found none", file=sys.stderr)
        return 2
    for figure in figures:
        shutil.copy(figure, docs / "images/reproduction" / figure.name)
    for (page, title), sections in changed.items():
        path = docs / "results" / f"{page}.md"
        kept = sections_in(path)
        bodies = "".join(f"\n## `{name}`\n\n{body}" for name, body in {**kept, **sections}.items())
        path.parent.mkdir(exist_ok=True)
        write_file(path, HEAD.format(title=title) + bodies)
        print(f"{path}: {', '.join(sections)}")
    page = docs / "reproduction.md"
    write_file(page, with_overview(page.read_text(encoding="utf-8"), docs))
    return 0
