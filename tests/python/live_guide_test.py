#!/usr/bin/env python3
"""The chapter "A running session" of docs/guides/python.md, and the examples that need one, beside a physics server."""
import os
import subprocess
import sys

from guide_test import BLOCK, LIVE_CHAPTER, ROOT, SHOWN, examples
from live_test import PATIENCE_S, LiveTest, unittest


class LiveGuide(LiveTest):
    def run_python(self, *arguments):
        done = subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=PATIENCE_S,
                              env={**self.environment, "MPLBACKEND": "Agg"}, cwd=ROOT)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done)
        return done.stdout

    def test_the_chapter_says_what_comes_out(self):
        self.begin()
        chapter, = LIVE_CHAPTER.findall((ROOT / "docs" / "guides" / "python.md").read_text(encoding="utf-8"))
        blocks = BLOCK.findall(chapter)
        self.assertGreater(len(blocks), 3)
        for block in blocks:
            with self.subTest(block):
                printed = self.run_python("-c", "import palpate, numpy as np\n" + block)
                self.assertEqual(printed.splitlines(), SHOWN.findall(block))

    def test_examples(self):
        self.begin()
        self.assertGreaterEqual(len(examples(live=True)), 2)
        short = {"watch.py": ["--seconds", "1"], "delays.py": ["--count", "20"]}
        for example in examples(live=True):
            with self.subTest(example.name):
                picture = self.path("plot.png")
                printed = self.run_python(example, "--out", picture, *short[example.name])
                self.assertIn("pingpong", printed)
                self.assertIn({"watch.py": " steps", "delays.py": "+-"}[example.name], printed)
                if "no picture" not in printed:
                    self.assertTrue(os.path.getsize(picture) > 5000)
                    os.remove(picture)


if __name__ == "__main__":
    unittest.main()
