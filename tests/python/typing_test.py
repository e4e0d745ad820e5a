#!/usr/bin/env python3
"""mypy --strict finds nothing in the package and in the examples, and something where an argument is of the wrong type; the
stubs of the extension modules say what these have."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
WRONG = """
import numpy as np
import palpate
result = palpate.calibrate_pivot(np.zeros((5, 4, 4)), method=3)
tip: str = result.tip
"""


class Typing(unittest.TestCase):
    def checked(self, *paths):
        with tempfile.TemporaryDirectory() as cache:
            return subprocess.run([os.environ["MYPY"], "--strict", "--cache-dir", cache, "--python-executable", "/usr/bin/python3",
                                   *map(str, paths)], capture_output=True, text=True, check=False,
                                  env={**os.environ, "MYPYPATH": str(ROOT / "python")}, cwd=cache)

    def test_the_package_and_the_examples_are_typed(self):
        done = self.checked(ROOT / "python" / "palpate", *sorted((ROOT / "examples" / "python").glob("*.py")))
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_a_wrong_type_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            wrong = pathlib.Path(folder) / "wrong.py"
            wrong.write_text(WRONG, encoding="ascii")
            done = self.checked(wrong)
        self.assertIn('Argument "method"', done.stdout)
        self.assertIn("Incompatible types in assignment", done.stdout)

    def test_the_stubs_are_what_is_there(self):
        allowed = pathlib.Path(__file__).with_name("stubtest_allowlist.txt")
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "palpate", "--concise", "--allowlist", str(allowed)],
                                  capture_output=True, text=True, check=False, env={**os.environ, "MYPYPATH": str(ROOT / "python")}, cwd=cache)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)


if __name__ == "__main__":
    unittest.main()
