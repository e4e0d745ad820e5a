#!/usr/bin/env python3
"""The long runs of scripts/soak, made short: they run, watch what they should, keep their samples and answer with their exit code."""
import csv
import os
import re
import subprocess
import sys
import unittest

from program import PATIENCE_S, PROGRAM, ProgramTest

SOAK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "soak.py")


class Soak(ProgramTest):
    def soak(self, part, program, seconds, *more):
        done = subprocess.run([sys.executable, SOAK, part, program, "--seconds", str(seconds), "--out", self.folder, *more],
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=2 * PATIENCE_S, check=False)
        self.assertEqual(done.stderr, "", done)
        lines = done.stdout.splitlines()
        self.assertEqual(done.returncode, 1 if any(re.search("GREW|not judged|[1-9][0-9]* lost|was lost [1-9]", line) for line in lines) else 0, done.stdout)
        return done.stdout

    def samples(self, name):
        with open(self.path(name), encoding="ascii") as file:
            return list(csv.DictReader(file))

    def verdict(self, table, figure):
        line = next((line for line in table.splitlines() if line.startswith(figure)), None)
        self.assertIsNotNone(line, table)
        return line.split("   ")[-1]

    def test_a_minute_of_lockstep(self):
        table = self.soak("lockstep", os.environ["LOCKSTEP_SOAK"], 60)
        for figure in ("descriptors of the play", "threads of the play", "clock error", "clock uncertainty", "round trip"):
            self.assertEqual(self.verdict(table, figure).strip(), "steady", table)  # virtual time: the same on every machine
        for figure in ("memory of the play", "work per virtual second"):
            self.verdict(table, figure)
        rows = self.samples("lockstep.csv")
        self.assertGreater(len(rows), 200)
        self.assertGreater(float(rows[-1]["time_s"]), 59)

    def test_seconds_in_real_time(self):
        runtime = os.environ.get("TEST_OPENXR_RUNTIME")  # not where the program is built without OpenXR
        table = self.soak("realtime", PROGRAM, 10, *(("--headset-runtime", runtime) if runtime else ()))
        for process in ("world", "physics", "graphics", "second graphics", "a second link", "an observer"):
            for figure in ("memory", "descriptors", "threads"):
                self.verdict(table, f"{figure} of {process}")
        for figure in ("overruns of haptic loop", "overruns of physics loop", "recorded by physics", "recorded by graphics"):
            self.verdict(table, figure)
        for figure in ("round trip", "between pictures", "clock error", "clock uncertainty"):
            self.verdict(table, figure + ", second")
            self.verdict(table, figure)
        for recorded in ("physics", "graphics"):
            self.assertRegex(table, f"(?m)^{recorded} recorded [0-9]+ MiB, [1-9][0-9]* messages, [0-9]+ lost$")
        self.assertEqual("headset: " in table, bool(runtime), table)
        self.assertGreater(len(self.samples("realtime.csv")), 4)
        for folder in ("", "second"):
            self.assertGreater(len(self.samples(os.path.join(folder, "realtime_frames.csv"))), 0)

    def test_a_run_that_cannot_be_is_told_in_one_line(self):
        done = subprocess.run([sys.executable, SOAK, "lockstep", "/bin/false", "--seconds", "5", "--out", self.folder],
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(done.returncode, 1, done)
        self.assertRegex(done.stderr, "^soak: /bin/false ended with exit 1 after 0 samples\n$")


if __name__ == "__main__":
    unittest.main()
