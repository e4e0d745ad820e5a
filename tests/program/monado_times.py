#!/usr/bin/env python3
"""By hand, on a machine with nothing else to do: when Monado's window shows a picture, beside when its runtime said that it would, and
how steadily frames go on while nobody hands anything over.

    PALPATE=... HEADSET_DOTS=build/dev/tests/palpate_headset_dots /usr/bin/python3 tests/program/monado_times.py

MONADO_SCALE: size of what the compositor draws on the way, in percent of what it would choose; a processor draws 15 in time."""
import os
import statistics
import threading
import time
import unittest

from monado import EYE_PX, Dots, MonadoTest, run_alone
from program import wait_until

PICTURES, SECONDS = 300, 10.0
LEVELS = [40 + 12 * i for i in range(16)]  # told apart, and none of them black
ALLOWED_MS, SHARE = 3.0, 0.95


class Times(MonadoTest):
    def monado_settings(self):
        return {"XRT_COMPOSITOR_SCALE_PERCENTAGE": os.environ.get("MONADO_SCALE", "15"), "U_PACING_COMP_MIN_TIME_MS": os.environ.get("MONADO_COMPOSITOR_MS", "3")}

    def watch(self, window, seen, stop):
        """When a pixel near the middle of the left eye's view first had another value."""
        before = None
        while not stop.is_set():
            level = window.get_image(EYE_PX[0] // 2, EYE_PX[1] // 2, 1, 1, 2, 0xffffffff).data[0]
            if level != before:
                seen.append((level, time.monotonic_ns()))
            before = level
            time.sleep(0.0003)

    def test_pictures_are_seen_when_the_runtime_says(self):
        dots = Dots(self)
        dots("level 255")
        wait_until(lambda: self.window() is not None, "Monado's window is there")
        seen, stop, said = [], threading.Event(), []
        watcher = threading.Thread(target=self.watch, args=(self.window(), seen, stop))
        watcher.start()
        for i in range(PICTURES):
            level = LEVELS[i % len(LEVELS)]
            said.append((level, dots(f"level {level}")["displayed_ns"]))
            time.sleep(0.035)
        time.sleep(0.5)
        stop.set()
        watcher.join()
        late_ms = []
        for level, displayed in said:
            after = [ns for shown, ns in seen if shown == level and abs(ns - displayed) < 2e8]
            if after:
                late_ms.append(1e-6 * (after[0] - displayed))
        late_ms.sort()
        median = statistics.median(late_ms)
        print(f"seen after the predicted time: median {median:.2f} ms, 5 % {late_ms[len(late_ms) // 20]:.2f}, 95 % {late_ms[-len(late_ms) // 20]:.2f};"
              f" {len(late_ms)} of {PICTURES} pictures")
        self.assertLess(abs(median), ALLOWED_MS)

    def test_frames_go_on_at_the_displays_rate(self):
        dots = Dots(self)
        dots("dots")
        time.sleep(1.0)
        before = dots("facts")
        time.sleep(SECONDS)
        after = dots("facts")
        wanted = (after["now_ns"] - before["now_ns"]) / after["period_ns"]
        share = (after["with_picture"] - before["with_picture"]) / wanted
        print(f"frames with the picture: {share:.3f} of the {wanted:.0f} of the display ({1e9 / after['period_ns']:.1f} Hz)")
        self.assertGreaterEqual(share, SHARE)


if __name__ == "__main__":
    run_alone()
    unittest.main()
