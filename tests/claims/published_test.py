#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pages and experiments show the published figures of published.csv. Usage: published_test.py SOURCE_DIR"""
import ast
import math
import pathlib
import sys
import unittest

SOURCE = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(SOURCE / "tools/experiments"))
from shared import pages, published  # noqa: E402
from shared.tables import read_markdown  # noqa: E402

VERDICTS = ("reproduced", "better", "differs", "other conditions")


class Published(unittest.TestCase):
    def test_numbers_and_deviations_are_read_from_the_text(self):
        length = published.find("rbl-forest", "L [m]")
        self.assertEqual((length.text, length.value, length.deviation), ("91.99 ± 0.96", 91.99, 0.96))
        never = published.find("occupancy-filters", "scans in which G(v) is confident occupied")
        self.assertTrue(math.isnan(never.value) and math.isnan(never.deviation))
        self.assertEqual(published.find("uncertainty-table", "mean difference over all regions").value, 1.26e-6)

    def test_a_star_stands_for_any_beginning_within_its_experiment(self):
        self.assertIsNotNone(published.find("rbl-circle", "circle N=5 R=10 2d: success [-]"))
        self.assertIsNone(published.find("rbl-circle", "circle N=5 R=10 2d: success [-]; L [m], t [s]"))
        self.assertIsNone(published.find("rbl-real", "sphere of 10 m: success [-]"))

    def test_every_figure_belongs_to_an_experiment(self):
        experiments = {path.stem.replace("_", "-") for path in (SOURCE / "tools/experiments").glob("[!_]*.py")}
        for (experiment, what), figure in published.FIGURES.items():
            self.assertIn(experiment, experiments)
            self.assertTrue(figure.text and figure.source, what)
        lines = [line for line in published.FILE.read_text(encoding="utf-8").splitlines() if line]
        self.assertEqual(len(published.FIGURES), len(lines) - 1, "every figure stands once")

    def test_every_experiment_names_its_document(self):
        for file in (SOURCE / "tools/experiments").glob("[!_]*.py"):
            self.assertTrue(pages.page_of(ast.get_docstring(ast.parse(file.read_text(encoding="utf-8")))), file)

    def test_result_tables_show_the_same(self):
        compared = 0
        for page, _ in pages.PAGES.values():
            for experiment, text in pages.sections_of((SOURCE / f"docs/results/{page}.md").read_text(encoding="utf-8")).items():
                for row in (row for table in read_markdown(text) for row in table if "verdict" in row):
                    figure, name, verdict = published.find(experiment, row["what"]), f"{experiment}: {row['what']}", row["verdict"]
                    self.assertEqual(row["published"], figure.text if figure else "-", name)
                    self.assertIn(verdict, VERDICTS if figure else ("no published figure",), name)
                    self.assertFalse(verdict in VERDICTS[:3] and not row["tolerance"], f"{name} has no tolerance")
                    compared += figure is not None
        self.assertGreater(compared, 80)

    def test_the_overview_leads_to_every_section(self):
        overview = (SOURCE / "docs/reproduction.md").read_text(encoding="utf-8")
        for page, _ in pages.PAGES.values():
            for experiment in pages.sections_of((SOURCE / f"docs/results/{page}.md").read_text(encoding="utf-8")):
                self.assertIn(f"[{experiment}](results/{page}.md#{experiment})", overview)

    def test_the_overview_shows_the_results_of_the_pages(self):
        text = (SOURCE / "docs/reproduction.md").read_text(encoding="utf-8")
        self.assertEqual(text, pages.with_overview(text), "tools/reproduce --write-docs writes it")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
