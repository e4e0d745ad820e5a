#!/usr/bin/env python3
"""The examples of the guides to Python and of examples/python run as they stand; those of a running session: live_guide_test.py."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SHOWN = re.compile(r"^ *#> ?(.*)$", re.MULTILINE)
LIVE_CHAPTER = re.compile(r"^## A running session$.*?(?=^## )", re.MULTILINE | re.DOTALL)
LIVE_EXAMPLES = ("delays.py", "watch.py")


def examples(live):
    return [path for path in sorted((ROOT / "examples" / "python").glob("*.py")) if (path.name in LIVE_EXAMPLES) == live]


class Guide(unittest.TestCase):
    def run_python(self, *arguments, **how):
        done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False,
                              env={**os.environ, "MPLBACKEND": "Agg"}, **how)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_the_guides_say_what_comes_out(self):
        """Its blocks one after the other, in the project's folder; lines "#> ..." are what a block prints."""
        for guide in ("python", "python-experiments"):
            with self.subTest(guide):
                text = LIVE_CHAPTER.sub("", (ROOT / "docs" / "guides" / f"{guide}.md").read_text(encoding="utf-8"))
                blocks = BLOCK.findall(text)
                self.assertGreater(len(blocks), 3)
                printed = self.run_python("-c", "\n".join(blocks), cwd=ROOT)
                self.assertEqual(printed.splitlines(), [line for block in blocks for line in SHOWN.findall(block)])

    def test_examples(self):
        self.assertGreaterEqual(len(examples(live=False)), 4)
        for example in examples(live=False):
            with self.subTest(example.name), tempfile.TemporaryDirectory() as folder:
                printed = self.run_python(str(example), "--out", str(pathlib.Path(folder) / "plot.png"))
                self.assertIn("+-", printed)


if __name__ == "__main__":
    unittest.main()
