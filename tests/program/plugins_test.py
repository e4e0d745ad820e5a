#!/usr/bin/env python3
"""Plug-ins as a user meets them: named, found in folders, refused. What a plug-in may be is the loader's test."""
import os
import shutil
import unittest

from program import ProgramTest

GUESTS = os.environ["HOSTILE_GUESTS"]  # a plug-in as good as any, as long as nobody plays it


class Plugins(ProgramTest):
    def setUp(self):
        super().setUp()
        self.home = os.path.join(self.root, "home")
        self.own = os.path.join(self.home, ".local/lib/palpate/plugins")
        self.environment["HOME"] = self.home
        self.environment.pop("PALPATE_PLUGIN_PATH", None)

    def put(self, folder):
        os.makedirs(folder, mode=0o755, exist_ok=True)
        place = shutil.copy(GUESTS, os.path.join(folder, "guests.so"))
        os.chmod(place, 0o644)
        return place

    def test_one_that_is_named_is_listed_with_where_it_comes_from(self):
        place = self.put(self.folder)
        for arguments in (("--plugin", place, "apps"), ("apps", "--plugin", place), ("apps", f"--plugin={place}"), ("--plugin", place, "apps", "--plugin", place)):
            listed = [line for line in self.runs(*arguments).out.splitlines() if line.startswith("thrower ")]
            self.assertEqual(len(listed), 1)
            self.assertIn(f"(plug-in {os.path.realpath(place)})", listed[0])
        self.assertNotIn("thrower", self.runs("apps").out)
        self.assertIn("--plugin", self.runs("--help").out)

    def test_folders_of_the_user_and_of_the_environment_are_looked_through(self):
        self.put(self.own)
        self.assertIn("thrower", self.runs("apps").out)
        shutil.rmtree(self.own)
        other = self.put(self.path("others"))
        for path in (os.path.dirname(other), other, f"{self.own}:{other}"):
            self.environment["PALPATE_PLUGIN_PATH"] = path
            self.assertIn("thrower", self.runs("apps").out, path)

    def test_one_in_a_folder_that_cannot_be_used_is_left_out_with_a_line(self):
        place = self.put(self.own)
        os.chmod(place, 0o666)
        done = self.runs("apps")
        self.assertNotIn("thrower", done.out)
        self.assertEqual(len(done.lines), 1, done)
        for words in ("palpate: left out: plug-in", "others may write to the file", "chmod go-w"):
            self.assertIn(words, done.lines[0])

    def test_one_that_is_named_and_cannot_be_used_ends_the_command_with_a_line(self):
        self.refuses(("apps", "--plugin", "absent.so"), 2, "absent.so", "no such file")
        self.refuses(("apps", "--plugin"), 2, "--plugin", "a file is expected")
        self.refuses(("apps", "--plugin", self.write("words.so", "no library")), 1, "words.so", "cannot be loaded")
        place = self.put(self.folder)
        os.chmod(self.folder, 0o777)
        self.refuses(("apps", "--plugin", place), 1, "others may write to the folder", self.folder)


if __name__ == "__main__":
    unittest.main()
