#!/usr/bin/env python3
"""palpate study psychometric: curves of people's tables, and tables that are refused."""
import json
import unittest

from program import ProgramTest

COUNTS = "stimulus,positives,trials\n1.05,11,20\n1.1,14,20\n1.2,16,20\n1.4,20,20\n"


class Psychometric(ProgramTest):
    def study(self, content, *options):
        self.write("trials.csv", content)
        return ["study", "psychometric", "--trials", "trials.csv", "--repeats", "200", *options]

    def test_a_table_of_counts_gives_a_curve_a_page_and_the_same_figures_again(self):
        self.runs(*self.study(COUNTS, "--guess", "0.5", "--out", "out", "--json", "result.json"))
        result = json.loads(self.read("result.json"))
        (group,) = result["groups"]
        low, high = group["threshold_interval"]
        self.assertLess(low, group["threshold"])
        self.assertLess(group["threshold"], high)
        self.assertEqual(group["trials"], 80)
        page = self.read("out", "report.html")
        for told in (b"Psychometric curves", b"threshold, 95 %", b"80 trials of trials.csv"):
            self.assertIn(told, page)
        before = self.read("result.json")
        self.runs(*self.study(COUNTS, "--guess", "0.5", "--json", "result.json"))
        self.assertEqual(self.read("result.json"), before)

    def test_trials_are_split_by_columns_and_what_does_not_count_is_left_out(self):
        lines = ["stimulus,response,sight,practice,excluded"]
        for sight, shares in (("with", (5, 20, 45, 70, 90, 97)), ("without", (0, 10, 30, 55, 80, 95))):
            for i in range(198):
                level, turn = i % 6, i // 6
                lines.append(f"{(0.7, 0.85, 1.0, 1.15, 1.3, 1.5)[level]},{int(turn * 37 % 100 < shares[level])},{sight},0,0")
            lines.append(f"1,1,{sight},1,0")
            lines.append(f"1,1,{sight},0,1")
        self.runs(*self.study("\n".join(lines) + "\n", "--comparison", "--by", "sight", "--json", "result.json"))
        result = json.loads(self.read("result.json"))
        self.assertEqual((result["trials"], result["practice"], result["excluded"]), (396, 2, 2))
        self.assertEqual([group["by"]["sight"] for group in result["groups"]], ["with", "without"])
        with_sight, without = result["groups"]
        self.assertLess(with_sight["threshold"], without["threshold"])
        for group in result["groups"]:
            low, high = group["weber_fraction_interval"]
            self.assertTrue(low < group["weber_fraction"] < high)

    def refused(self, content, exit_code, *words, options=()):
        self.refuses(self.study(content, *options, "--json", "result.json"), exit_code, *words)

    def test_tables_that_are_none_are_named_with_line_and_column(self):
        self.refuses(["study", "psychometric", "--trials", "nowhere.csv"], 2, "nowhere.csv", "no such file")
        self.refused("", 2, "trials.csv", "is empty")
        self.refused("force,response\n1,1\n", 2, "trials.csv: column 'stimulus' is missing", "force,response")
        self.refused("stimulus,right\n1,1\n", 2, "trials.csv", "neither a column 'response'", "--response")
        self.refused("stimulus,response\n1,2\n", 2, "trials.csv:2: response is '2'; 1 or 0")
        self.refused("stimulus,response\n1,yes\n", 2, "trials.csv:2: response is 'yes'; 1 or 0")
        self.refused("stimulus,response\n1,1\n0,1\n", 2, "trials.csv:3: stimulus is '0'; a stimulus above 0")
        self.refused("stimulus,response\n1,1\nnan,1\n", 2, "trials.csv:3: stimulus is 'nan'")
        self.refused("stimulus,positives,trials\n1,3,2\n", 2, "trials.csv:2: positives is '3'; at most 2")
        self.refused(COUNTS, 2, "column 'sight' is missing", options=["--by", "sight"])

    def test_answers_that_tell_nothing_are_refused_with_a_code(self):
        self.refused("stimulus,response,practice\n1,1,1\n", 1, "trials.csv", "no trial that counts")
        for rows, code in (("1,10,10\n2,10,10\n", "all_positive"), ("1,0,10\n2,0,10\n", "all_negative"),
                           ("1,5,10\n", "one_level"), ("1,9,10\n2,5,10\n", "no_rise")):
            self.refused("stimulus,positives,trials\n" + rows, 1, f"({code})")


if __name__ == "__main__":
    unittest.main()
