#!/usr/bin/env python3
"""Curves, staircases, observers and runs of experiments: the program's figures to the last bit, and what was put in comes out."""
import csv
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

import palpate

PROGRAM = os.environ["PALPATE"]
CONDITIONS = """
name = "larger"
question = "Which of the two is larger?"
task = "comparison"
stimulus = "ratio"
method = "constant-stimuli"
practice = 3
rest_after = 40
repeat_excluded = true

[constant]
levels = [0.7, 0.85, 1.15, 1.4]
repeats = 15

[[factor]]
name = "sight"
choices = ["with", "without"]
"""


def answered(run, observer, until=None):
    """Goes on with the run, answered by the observer; every tenth trial is left out once."""
    for trial in run:
        if until is not None and run.answered >= until:
            return
        pair = [1.0, 1.0]
        pair[trial.target - 1] = trial.stimulus
        left_out = trial.number % 10 == 0 and trial.repeated == 0
        run.answer(1 + observer.largest(pair), 0.5, 2.0 * trial.number, "force-limited" if left_out else "")


class Experiments(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.conditions = palpate.Conditions.parse(CONDITIONS)

    def program(self, table, *options):
        figures = self.folder / "figures.json"
        subprocess.run([PROGRAM, "study", "psychometric", "--trials", str(table), "--json", str(figures), *options], capture_output=True, check=True)
        return json.loads(figures.read_text(encoding="utf-8"))["groups"]

    def test_a_curve_is_the_programs(self):
        table = self.folder / "table.csv"
        table.write_text("stimulus,positives,trials\n1.05,11,20\n1.1,14,20\n1.2,16,20\n1.4,20,20\n", encoding="ascii")
        fit = palpate.fit_psychometric([1.05, 1.1, 1.2, 1.4], positives=[11, 14, 16, 20], trials=[20] * 4, guess=0.5)
        expected, = self.program(table, "--guess", "0.5")
        self.assertEqual(json.dumps(fit.to_dict()), json.dumps(expected))
        self.assertEqual(list(fit.threshold_interval), expected["threshold_interval"])
        self.assertAlmostEqual(float(fit.chance([fit.stimulus_at(0.75)])[0]), 0.75, 12)

    def test_a_run_is_what_the_program_says_of_its_file(self):
        file = self.folder / "run.csv"
        run = palpate.ExperimentRun(self.conditions, 5, out=file)
        answered(run, palpate.Observer(seed=5))
        told = run.to_dict()
        # The program's groups come in the order in which the file has them.
        expected = sorted(self.program(file, "--comparison", "--by", "sight"), key=lambda group: group["by"]["sight"])
        self.assertEqual(json.dumps(told["groups"]), json.dumps(expected))
        self.assertTrue(told["finished"])
        self.assertEqual(told["trials"], 4 * 15 * 2)
        self.assertGreater(told["excluded"], 5)
        with file.open(encoding="utf-8") as lines:
            rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        table = run.table
        self.assertEqual(len(rows), len(table["trial"]))
        self.assertEqual([float(row["stimulus"]) for row in rows], list(table["stimulus"]))
        self.assertEqual([row["response"] == "1" for row in rows], list(table["response"]))
        self.assertEqual([row["sight"] for row in rows], list(table["sight"]))

    def test_order_and_places_follow_from_the_seed_and_are_balanced(self):
        def order(seed):
            run = palpate.ExperimentRun(self.conditions, seed)
            trials = []
            for trial in run:
                trials.append(trial)
                run.answer(1)
            return trials

        first, again, other = order(7), order(7), order(8)
        self.assertEqual(first, again)
        self.assertNotEqual([t.stimulus for t in first], [t.stimulus for t in other])
        counted = [t for t in first if not t.practice]
        for block in range(1, 16):
            self.assertEqual(len({(t.stimulus, t.levels["sight"]) for t in counted if t.block == block}), 8)
        self.assertLessEqual(abs(sum(t.target == 1 for t in counted) - 60), 8)

    def test_a_run_that_was_broken_off_goes_on(self):
        whole = palpate.ExperimentRun(self.conditions, 3, out=self.folder / "whole.csv")
        answered(whole, palpate.Observer(seed=3))
        broken = palpate.ExperimentRun(self.conditions, 3, out=self.folder / "broken.csv")
        observer = palpate.Observer(seed=3)
        answered(broken, observer, until=31)
        del broken
        with (self.folder / "broken.csv").open("a", encoding="ascii") as file:
            file.write("32,0,3,0")  # the power went
        taken = palpate.ExperimentRun(self.conditions, 3, out=self.folder / "broken.csv", take_up=True)
        self.assertEqual(taken.answered, 31)
        answered(taken, observer)
        self.assertEqual((self.folder / "broken.csv").read_bytes(), (self.folder / "whole.csv").read_bytes())
        with self.assertRaisesRegex(ValueError, "seed"):
            palpate.ExperimentRun(self.conditions, 4, out=self.folder / "whole.csv", take_up=True)
        with self.assertRaises(ValueError):
            palpate.ExperimentRun(self.conditions, 3, out=self.folder / "whole.csv")

    def test_a_staircase_closes_in_on_the_share_it_seeks(self):
        rule = palpate.StaircaseRule(down_after=2, start=3.0, step_factors=(1.3, 1.1, 1.05), reversals=14, most_trials=300)
        self.assertAlmostEqual(rule.share_sought(), np.sqrt(0.5), 12)
        logs = []
        for seed in range(60):
            observer, staircase = palpate.Observer(0.2, 0.0, seed), palpate.Staircase(rule)
            while not staircase.finished:
                staircase.answer(observer.largest([staircase.stimulus, 1.0]) == 0)
            logs.append(np.log(staircase.threshold().stimulus))
        # Right at this share where ln x = z(0.707) times the noise of a comparison, ln 1.2 / z(0.75).
        sought = 0.5446 * np.log(1.2) / 0.6745
        self.assertAlmostEqual(np.mean(logs), sought, delta=0.25 * sought)

    def test_staircases_take_turns(self):
        rules = [palpate.StaircaseRule(start=2.0, most_trials=12), palpate.StaircaseRule(kind="weighted", target=0.8, start=4.0, most_trials=12)]
        both = palpate.InterleavedStaircases(rules, 1)
        turns = []
        while not both.finished:
            turns.append(both.next)
            self.assertEqual(both.stimulus, both.all[both.next].stimulus)
            both.answer(None if len(turns) == 3 else len(turns) % 3 > 0)
        self.assertEqual(sorted(turns[:2]), [0, 1])
        self.assertLessEqual(max(one.trials for one in both.all), 12)
        with self.assertRaisesRegex(RuntimeError, "one of several"):
            both.all[0].answer(True)

    def test_an_observer_is_as_good_as_it_says(self):
        observer = palpate.Observer(0.2, 0.0, 9)
        right = sum(observer.largest([1.0, 1.2]) for _ in range(4000))
        self.assertAlmostEqual(right / 4000, 0.75, delta=0.025)
        self.assertEqual(list(palpate.Observer(seed=4).perceived([1.0, 2.0])), list(palpate.Observer(seed=4).perceived([1.0, 2.0])))
        self.assertTrue(observer.is_above([100.0], 1.0)[0])
        self.assertAlmostEqual(palpate.practised_weber_fraction(0), 0.28)
        self.assertAlmostEqual(palpate.weber_fraction(palpate.spread_of_weber_fraction(0.14)), 0.14)

    def test_answers_that_tell_no_curve_are_refused_by_name(self):
        for positives, code in (([20, 20, 20], "all_positive"), ([0, 0, 0], "all_negative"), ([10, 10, 10], "no_rise")):
            with self.assertRaises(palpate.Refused) as caught:
                palpate.fit_psychometric([1.0, 1.2, 1.5], positives=positives, trials=[20] * 3, guess=0.0)
            self.assertEqual(caught.exception.code, code)

    def test_wrong_arguments_in_words(self):
        for words, call in (
                ("either responses", lambda: palpate.fit_psychometric([1.0, 2.0])),
                (r"responses\[1\] is 2", lambda: palpate.fit_psychometric([1.0, 2.0], [1, 2])),
                ("above 0", lambda: palpate.fit_psychometric([0.0, 2.0], [1, 0])),
                (r"positives\[0\] is 5, of 4", lambda: palpate.fit_psychometric([1.0], positives=[5], trials=[4])),
                ("weber_fraction is 0", lambda: palpate.Observer(0.0)),
                ("kind is 'up'", lambda: palpate.StaircaseRule(kind="up")),
                ("start", lambda: palpate.StaircaseRule(start=20.0)),
                ("place is 3", lambda: palpate.ExperimentRun(self.conditions, 1).answer(3)),
                ("exclusion is 'tired'", lambda: palpate.ExperimentRun(self.conditions, 1).answer(1, exclusion="tired")),
                ("thing:2: task", lambda: palpate.Conditions.parse('name = "x"\ntask = "guess"\n', "thing"))):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                call()

    def test_conditions_come_back_from_their_text(self):
        for method in ("constant-stimuli", "staircase"):
            example = palpate.example_conditions(method)
            self.assertEqual(palpate.Conditions.parse(example.text()).hash, example.hash)
            self.assertEqual(example.method, method)


if __name__ == "__main__":
    unittest.main()
