#!/usr/bin/env python3
"""Manual pages and completion: every command and option of --help stands in both, groff and bash take them."""
import os
import re
import shutil
import subprocess
import unittest

from program import ProgramTest


class Manual(ProgramTest):
    def commands(self, words=()):
        """(words, options) of each command below, as --help tells them."""
        help_text = self.runs(*words, "--help").out
        yield words, re.findall(r"^  (?:-\w,)?(--[\w-]+)", help_text, re.M)
        _, _, below = help_text.partition("\nSubcommands:\n")
        for name in re.findall(r"^  ([a-z][\w-]*)", below, re.M):
            yield from self.commands((*words, name))

    def completed(self, *words):
        """What bash offers for the last word."""
        line = ("palpate", *words)
        script = ('source <("$PALPATE" completion bash); compopt() { :; }; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); '
                  '_palpate; printf "%s\\n" "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "-c", script, "bash", *line], capture_output=True, text=True, check=False, cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""), words)
        return done.stdout.split()

    def test_every_command_and_option_stands_in_both(self):
        self.runs("man", "--out", "pages")
        script = self.runs("completion", "bash").out
        count = 0
        for words, options in self.commands():
            page = self.read("pages", "-".join(("palpate", *words)) + ".1").decode().replace("\\-", "-")
            offered = re.search(r"^    %s\) options='([^']*)' words='([^']*)'" % ("/" + "/".join(words) if words else "''"), script, re.M)
            self.assertIsNotNone(offered, words)
            for option in options:
                self.assertIn(f"\\fB{option}\\fR", page, words)
                self.assertIn(option, offered[1].split(), words)
            if words:
                above = re.search(r"^    %s\) options='[^']*' words='([^']*)'" % ("/" + "/".join(words[:-1]) if words[:-1] else "''"), script, re.M)
                self.assertIn(words[-1], above[1].split())
            count += 1
        self.assertEqual(count, len(os.listdir(self.path("pages"))))
        self.assertGreater(count, 6)

    @unittest.skipUnless(shutil.which("groff"), "groff is not installed")
    def test_groff_takes_every_page_without_a_warning(self):
        self.runs("man", "--out", "pages")
        pages = [self.path("pages", name) for name in sorted(os.listdir(self.path("pages")))]
        done = subprocess.run(["groff", "-ww", "-man", "-z", "-Kutf8", "-Tutf8", *pages], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_one_page_by_the_words_of_its_command(self):
        self.assertIn("PALPATE\\-PHYSICS 1", self.runs("man", "physics").out)
        self.refuses(["man", "physic"], 2, "'physic': no such command")
        self.refuses(["completion", "tcsh"], 2, "bash")

    def test_bash_completes(self):
        self.write("some.rig.toml", "")
        os.mkdir(self.path("folder"))
        self.assertEqual(self.completed("phy"), ["physics"])
        self.assertEqual(self.completed("help", "phy"), ["physics"])
        self.assertIn("--listen", self.completed("physics", "--li"))
        self.assertEqual(self.completed("physics", "--rig", "some"), ["some.rig.toml"])
        self.assertEqual(self.completed("physics", "--rig", "=", "some"), ["some.rig.toml"])
        self.assertEqual(self.completed("completion", ""), ["bash"])
        self.assertIn("--log", self.completed("--l"))
        self.assertEqual(self.completed("physics", "--log", "some"), ["some.rig.toml"])


if __name__ == "__main__":
    unittest.main()
