#!/usr/bin/env python3
"""The package as such: stubs, docstrings, what it imports. Usage: see support.py."""
import ast
import inspect
import runpy
import subprocess
import sys

import support
import swiftlet
import swiftlet.learning


class Package(support.InFolder):
    def test_stubs_match_the_docstrings_of_the_module(self):
        written = (support.SOURCE / "sim/python/swiftlet/_core.pyi").read_text()
        ast.parse(written)
        made = runpy.run_path(str(support.SOURCE / "tests/python/stubs.py"))["stubs"]()
        self.assertEqual(written, made, "renew: tests/python/stubs.py > sim/python/swiftlet/_core.pyi")

    def test_everything_public_has_a_docstring(self):
        for module in (swiftlet, swiftlet.learning, swiftlet.functions, swiftlet.results, swiftlet.datasets):
            self.assertTrue(module.__doc__, module)
            for name in module.__all__:
                value = getattr(module, name)
                if inspect.isclass(value) or inspect.isroutine(value):
                    self.assertTrue(value.__doc__, f"{module.__name__}.{name}")

    def test_it_imports_numpy_and_nothing_else(self):
        result = subprocess.run([sys.executable, "-c", "import sys, swiftlet; print(sorted({m.split('.')[0] for m in sys.modules} & "
                               "{'pandas', 'matplotlib', 'gymnasium', 'pettingzoo', 'yaml', 'scipy'}))"], capture_output=True,
                              text=True, check=True)
        self.assertEqual(result.stdout, "[]\n")


if __name__ == "__main__":
    support.main()
