#!/usr/bin/env python3
"""The help of every command: what options take in words of ours, lines that fit a terminal, examples whose options there are."""
import re
import shlex
import unittest

from program import ProgramTest

WIDTH = 118


class Help(ProgramTest):
    def pages(self):
        """Of the program and of every command below it: its words, its help."""
        found, waiting = {}, [()]
        while waiting:
            command = waiting.pop()
            page = self.runs(*command, "--help").out
            found[command] = page
            below = page.partition("Subcommands:\n")[2]
            waiting += [(*command, name) for name in re.findall(r"^  ([a-z][a-z-]*)\b", below, re.M)]
        return found

    def test_every_page_is_in_our_words_fits_a_terminal_and_has_examples_that_are_options_of_the_command(self):
        pages = self.pages()
        self.assertGreater(len(pages), 50)
        examples = 0
        for command, page in pages.items():
            with self.subTest(command=" ".join(command)):
                self.assertNotIn("{", page)
                self.assertNotRegex(page, r"\b(TEXT|FLOAT|INT|UINT|REQUIRED)\b")
                self.assertLessEqual(max(map(len, page.splitlines())), WIDTH)
                for line in re.findall(r"^  palpate (.*)$", page.partition("\nExample, ")[2], re.M):
                    words = shlex.split(line)
                    self.assertEqual(tuple(words[:len(command)]), command)
                    for option in (word for word in words if word.startswith("--")):
                        self.assertRegex(page, rf"(?m)^  (-\w,)?{option}\b")
                    examples += 1
        self.assertGreaterEqual(examples, 17)

    def test_help_is_a_command_too(self):
        self.assertEqual(self.runs("help", "calibrate", "arm").out, self.runs("calibrate", "arm", "--help").out)
        self.assertEqual(self.runs("help").out, self.runs("--help").out)

    def test_help_of_what_there_is_not_is_an_error(self):
        for asked in (["help", "calibrat"], ["calibrat", "--help"], ["calibrat", "-h"]):
            self.refuses(asked, 2, "calibrat: no such command; did you mean 'calibrate'?")
        self.refuses(["help", "calibrate", "pivto"], 2, "pivto: no such command; did you mean 'pivot'?")
        self.assertIn("--samples", self.runs("calibrate", "arm", "--samples", "no.csv", "--help").out)


if __name__ == "__main__":
    unittest.main()
