#!/usr/bin/env python3
"""A program that was built without applications says so, and does what needs none."""
import unittest

from program import ProgramTest


class NoApplication(ProgramTest):
    def test_what_plays_says_that_there_is_none(self):
        listed = self.run_program("apps")
        self.assertEqual((listed.code, listed.out), (0, ""))
        self.assertIn("this program has no application", listed.err)
        self.says_no(self.run_program("demo", "--headless"), 2, "this program has no application")
        self.says_no(self.run_program("picture"), 2, "this program has no application")
        self.says_no(self.run_program("demo", "--app", "darts"), 2, "this program has no application")

    def test_a_world_file_that_names_settings_of_others_is_read(self):
        self.runs("world", "new", "lab.toml")
        self.assertNotIn("[ball]", self.runs("world", "show", "lab.toml").out)
        self.says_no(self.run_program("world", "show", self.write("touch.toml", "[touch]\nscale = 2.0\n")), 2, "touch.toml:1", "touch")
        self.runs("world", "sample", "pivot", "--world", "lab.toml", "--points", "20", "--out", "samples")


if __name__ == "__main__":
    unittest.main()
