#!/usr/bin/env python3
"""Devices that fail, from outside: a laboratory whose camera and tracker go wrong on purpose, two servers and a window on a desktop
of its own. Each fault is told in the log, on the screen and by `palpate status`, ends by itself, and forces do not hear of it.
How soon is printed (and written where KEEP_FIGURES names a file); a busy machine may take its time."""
import json
import os
import signal
import time
import unittest

from display import Desktop
from laboratory import LaboratoryTest, told
from program import wait_until

# What holds when, s of a round: fault, span, words in the log, words of its end.
FAULTS = (("camera_silent", 1.0, 1.8, "camera: no image any more", "camera: images come again"),
          ("image_size", 2.6, 3.4, "camera: images have 320 x 240 pixels, the rig is calibrated for 640 x 480",
           "camera: images have the calibrated size again"),
          ("tracker_blind", 4.2, 5.0, "tracker: does not see the head's marker", "tracker: sees the head's marker again"),
          ("tracker_silent", 5.8, 6.6, "tracker: no samples", "tracker: samples come again"),
          ("camera_clock", 7.4, 8.0, "camera: its clock was set or stood still", "camera: its clock is known again"),
          ("tracker_clock", 9.6, 10.2, "tracker: its clock was set or stood still", "tracker: its clock is known again"))
ROUND_S = 12.0


def amber(red, green, blue):
    """The ground of warnings."""
    return red > 215 and 140 < green < 215 and blue < 110


class Faults(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.desktop = Desktop()
        self.addCleanup(self.desktop.close)
        self.environment.update(DISPLAY=self.desktop.name, ALSOFT_DRIVERS="null")
        self.environment.pop("WAYLAND_DISPLAY", None)

    def warned(self):
        window = self.desktop.window("Palpate")
        return window is not None and self.desktop.picture(window).share((100, 60, 760, 240), amber, 5) > 0.02

    def seen_by_status(self):
        """What the live view of `palpate status` shows now: its last whole view."""
        text = self.status.output()
        views = text.split("pingpong at ipc://")
        last = -1 if text.endswith("\n\n") else -2
        return views[last] if len(views) > 2 else ""

    def soon(self, conditions):
        """Waits for all of these; how long after now each held."""
        begun, after = time.monotonic(), {}

        def look():
            for name, holds in conditions.items():
                if name not in after and holds():
                    after[name] = time.monotonic() - begun
            return len(after) == len(conditions)
        wait_until(look, f"{sorted(conditions)}; so far {after}, graphics: {self.graphics.lines()}")
        return after

    def log_has(self, words, since):
        return lambda: any(words in line for line in self.graphics.lines()[since:])

    def test_each_is_told_on_screen_in_the_log_and_by_status_and_ends_by_itself(self):
        self.write("faults.toml", "[camera]\ndrop_probability = 0.0\n[faults]\nrepeat_s = %g\n" % ROUND_S +
                   "".join("%s_s = [%g, %g]\n" % fault[:3] for fault in FAULTS))
        world = self.start_world("--world", "faults.toml")
        physics = self.start_physics("--json", "physics.json")
        self.graphics = self.start_graphics("--window", "--quality", "low", "--json", "graphics.json")
        wait_until(lambda: self.desktop.window("Palpate") is not None, "the window opens")
        self.desktop.resize(self.desktop.window("Palpate"), 960, 720)
        self.status = self.start("status", "--interval-s", "0.1")
        wait_until(lambda: self.seen_by_status() != "", "status shows something")
        figures = {}
        for name, _, _, words, end in FAULTS:
            begins, over = f"fault {name} begins", f"fault {name} is over"
            # A fault that held while the servers were still starting comes again.
            lines, since = len(world.lines()), len(self.graphics.lines())
            wait_until(lambda: any(begins in line for line in world.lines()[lines:]), begins)
            kind = words.split(":")[0] + ":"
            after = self.soon({"log": self.log_has(words, since), "screen": self.warned,
                              "status": lambda: f"! {kind}" in self.seen_by_status()})
            wait_until(lambda: any(over in line for line in world.lines()[lines:]), over)
            recovered = self.soon({"log": self.log_has(end, since), "screen": lambda: not self.warned(),
                                   "status": lambda: f"! {kind}" not in self.seen_by_status()})
            figures[name] = {"told_after_s": after, "recovered_after_s": recovered}
            print(name, "told:", ", ".join(f"{k} {v:.2f} s" for k, v in after.items()),
                  "| over:", ", ".join(f"{k} {v:.2f} s" for k, v in recovered.items()))
        self.graphics.send(signal.SIGTERM)
        done = self.graphics.ends()
        self.assertEqual(done.code, 0, done)
        begun = json.loads(self.read("graphics.json"))["graphics"]["conditions"]
        for name, *_ in FAULTS:
            self.assertGreaterEqual(begun[name], 1)
        physics.send(signal.SIGTERM)
        done = physics.ends()
        self.assertEqual((done.code, told(done)), (0, []), done)  # forces have not heard of it
        forces = json.loads(self.read("physics.json"))
        figures["haptic"] = {**forces["haptic"], "trips": forces["force"]["trips"]}
        print("haptic loop:", {key: forces["haptic"][key] for key in ("ticks", "overruns", "missed")}, "trips:", forces["force"]["trips"])
        if "KEEP_FIGURES" in os.environ:
            with open(os.environ["KEEP_FIGURES"], "w", encoding="ascii") as file:
                json.dump(figures, file, indent=1)
        world.send(signal.SIGTERM)
        self.assertEqual(world.ends().code, 0)

    def test_a_fault_that_cannot_be_is_refused_with_file_line_and_key(self):
        self.write("faults.toml", "[faults]\ncamera_dark_s = [1, 2]\n")
        self.refuses(["world", "run", "--world", "faults.toml"], 2, "faults.toml:2", "camera_dark_s")
        self.write("faults.toml", "[faults]\ntracker_blind_s = [2, 1]\n")
        self.refuses(["world", "run", "--world", "faults.toml"], 2, "faults.toml:2", "tracker_blind_s", "from <= until")


if __name__ == "__main__":
    unittest.main()
