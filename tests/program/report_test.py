#!/usr/bin/env python3
"""palpate report: a folder's page again, with templates and limits of one's own."""
import json
import os
import unittest

from program import ProgramTest

SUMMARY = json.dumps({"application": "pingpong", "arm": {"samples": 70, "error_to_truth_mean_mm": 0.25, "error_before_calibration_mm": 6.5, "eq7_error_to_truth_mm": 0.9}})
STRICT = '[arm_error]\nfigure = "arm/error_to_truth_mean_mm"\nunit = "mm"\nat_most = 0.2\n'


class Report(ProgramTest):
    def setUp(self):
        super().setUp()
        for folder in ("played", "mine"):
            os.mkdir(self.path(folder))
        self.write("played/summary.json", SUMMARY)

    def verdict(self):
        return json.loads(self.read("played", "report.json"))["judged"]["arm_error"]["verdict"]

    def test_limits_and_words_of_ones_own_take_their_place(self):
        self.assertIn("written to played/report.html", self.runs("report", "played").out)
        self.assertEqual(self.verdict(), "holds")
        self.assertNotIn(b"falls short", self.read("played", "report.html"))
        self.write("mine/limits.toml", STRICT)
        self.write("mine/demo-how.html", "<p>Built in one afternoon, {{arm.samples}} poses.</p>")
        self.runs("report", "played", "--templates", "mine")
        self.assertEqual(self.verdict(), "falls short")
        self.assertIn(b"falls short", self.read("played", "report.html"))
        self.assertIn(b"Built in one afternoon, 70 poses.", self.read("played", "report.html"))

    def test_a_studys_page_comes_out_the_same(self):
        self.runs("study", "reset", "--runs", "2", "--seed", "5", "--out", "studied")
        before = self.read("studied", "report.json"), self.read("studied", "report.html")
        os.remove(self.path("studied", "report.html"))
        self.runs("report", "studied")
        self.assertEqual((self.read("studied", "report.json"), self.read("studied", "report.html")), before)

    def test_what_is_no_report_and_what_is_no_template_is_refused(self):
        self.runs("report", "played")
        self.refuses(["report", "mine"], 2, "mine", "summary.json", "report.json")
        self.refuses(["report", "played", "--templates", "nowhere"], 2, "nowhere", "folder of templates")
        self.write("mine/report.json", "{")
        self.refuses(["report", "mine"], 2, "mine/report.json")
        os.remove(self.path("mine", "report.json"))
        page = self.read("played", "report.html")
        for words, told in (("{{arm.eror}}", "arm.eror"), ("{{>demo-how}}", "takes itself in"), ("{{#open}}", "open")):
            self.write("mine/demo-how.html", words)
            self.refuses(["report", "played", "--templates", "mine"], 2, "demo-how.html", told)
        for opening in ("{{>", "{{#", "{{"):  # a name without end ended the program
            self.write("mine/demo-how.html", opening + "a" * 2_000_000 + "}}")
            self.refuses(["report", "played", "--templates", "mine"], 2, "demo-how.html", "aaa")
        os.remove(self.path("mine", "demo-how.html"))
        self.write("mine/limits.toml", "[arm_error]\nfigure = 3\n")
        self.refuses(["report", "played", "--templates", "mine"], 2, "limits.toml:2")
        self.assertEqual(self.read("played", "report.html"), page)


if __name__ == "__main__":
    unittest.main()
