#!/usr/bin/env python3
"""Growth that has to be seen and noise that must not be taken for it, in made-up runs of nine minutes, a sample a second."""
import contextlib
import io
import random
import unittest

import soak
from soak_judge import judge, line

TIMES = [float(t) for t in range(540)]


def grew(values, figure, times=TIMES):
    return judge(times, values, soak.MARGINS[figure]).grew


class GrowthThatHasToBeSeen(unittest.TestCase):
    def test_a_leak_of_a_megabyte_a_minute(self):
        for seed in range(50):
            noise = random.Random(seed)
            self.assertTrue(grew([80 + t / 60 + noise.gauss(0, 0.3) for t in TIMES], "memory"))

    def test_the_same_leak_taken_from_the_system_two_megabytes_at_a_time(self):
        self.assertTrue(grew([80 + 2 * (t // 120) for t in TIMES], "memory"))

    def test_a_descriptor_or_a_thread_a_minute(self):
        for figure in ("descriptors", "threads"):
            self.assertTrue(grew([14 + int(t / 60) for t in TIMES], figure))

    def test_ten_microseconds_a_minute_of_latency_among_noise_and_peaks(self):
        for seed in range(50):
            noise = random.Random(seed)
            values = [250 + t / 6 + noise.gauss(0, 40) + (noise.random() < 0.05) * noise.expovariate(1 / 3000) for t in TIMES]
            self.assertTrue(grew(values, "latency"), seed)

    def test_a_clock_that_walks_off_by_ten_microseconds_a_minute(self):
        self.assertTrue(grew([15 + t / 6 for t in TIMES], "clock"))

    def test_pictures_that_become_fewer(self):
        for seed in range(50):
            noise = random.Random(seed)
            self.assertTrue(grew([40 + t / 30 + noise.gauss(0, 10) for t in TIMES], "pictures"), seed)

    def test_a_recording_that_takes_more_and_more(self):
        for seed in range(50):
            noise = random.Random(seed)
            self.assertTrue(grew([380 + t / 4 + noise.uniform(-100, 80) for t in TIMES], "disk"), seed)

    def test_overruns_that_become_more_frequent_every_minute(self):
        for seed in range(50):
            noise = random.Random(seed)
            self.assertTrue(grew([30 + t / 4 + noise.gauss(0, 20) for t in TIMES], "overruns"), seed)


class NoiseThatIsNoGrowth(unittest.TestCase):
    def false_alarms(self, figure, series, runs=300):
        return sum(grew(series(random.Random(seed)), figure) for seed in range(runs))

    def test_memory_that_goes_up_and_down(self):
        self.assertEqual(self.false_alarms("memory", lambda noise: [80 + noise.choice((0, 0.25, 2.0)) for _ in TIMES]), 0)

    def test_latency_with_a_heavy_tail(self):
        self.assertEqual(self.false_alarms("latency", lambda noise: [250 + noise.expovariate(1 / 200) for _ in TIMES]), 0)

    def test_latency_under_other_peoples_builds_that_come_and_go(self):
        def series(noise):
            values, busy = [], False
            for _ in TIMES:
                busy ^= noise.random() < 1 / 20  # for 20 s on average
                values.append(200 + noise.gauss(0, 30) + busy * noise.gauss(300, 60))
            return values
        self.assertLessEqual(self.false_alarms("latency", series), 3)  # of 300: chance

    def test_a_recording_of_rallies_and_pauses(self):
        self.assertLessEqual(self.false_alarms("disk", lambda noise: [noise.choice((290, 440, 450)) for _ in TIMES]), 1)

    def test_one_step_is_no_growth(self):
        for figure, step in (("memory", 5.0), ("descriptors", 1.0), ("threads", 1.0), ("latency", 200.0)):
            for at in range(60, 500, 40):
                self.assertFalse(grew([50 + step * (t > at) for t in TIMES], figure), (figure, at))

    def test_less_than_the_margin_is_no_growth_however_certain(self):
        self.assertFalse(grew([80 + 0.0005 * t for t in TIMES], "memory"))

    def test_what_falls_does_not_grow(self):
        self.assertFalse(grew([80 - t for t in TIMES], "memory"))


class WhatIsToldAtTheEnd(unittest.TestCase):
    HEADSET = {"frames": 900, "rate_hz": 90.0, "pictures_shown": 200, "losses": 0, "age_ms": {"median": 40.0, "p99": 60.0}}

    def told(self, tell, *figures):
        with contextlib.redirect_stdout(io.StringIO()) as text:
            return tell(*figures), text.getvalue()

    def test_a_message_that_no_recording_holds_is_told(self):
        def figures(dropped, missed):
            return {"physics": {"recording": {"bytes": 2**21, "messages": 7, "dropped": {"/arm/sample": dropped}, "missed": missed}},
                    "graphics": {"recording": {"bytes": 2**20, "messages": 3, "dropped": {}}}}
        self.assertEqual(self.told(soak.tell_recordings, figures(0, 0)),
                         (0, "physics recorded 2 MiB, 7 messages, 0 lost\ngraphics recorded 1 MiB, 3 messages, 0 lost\n"))
        self.assertEqual(self.told(soak.tell_recordings, figures(4, 5))[0], 9)

    def test_a_headset_that_went_or_showed_nothing_is_told(self):
        bad, text = self.told(soak.tell_headset, self.HEADSET, 10.0)
        self.assertEqual(bad, 0)
        self.assertIn("90.0 frames/s", text)
        self.assertIn("20.0 new pictures/s", text)
        self.assertEqual(self.told(soak.tell_headset, {**self.HEADSET, "losses": 2}, 10.0)[0], 2)
        self.assertEqual(self.told(soak.tell_headset, {**self.HEADSET, "pictures_shown": 0}, 10.0)[0], 1)


class Arithmetic(unittest.TestCase):
    def test_slope_and_error_are_those_of_the_textbook(self):
        slope, error = line([0.0, 1.0, 2.0, 3.0], [1.0, 3.0, 2.0, 4.0])  # errors -0.3, 0.9, -0.9, 0.3
        self.assertAlmostEqual(slope, 0.8)
        self.assertAlmostEqual(error, (1.8 / 2 / 5) ** 0.5)

    def test_too_little_is_not_judged(self):
        self.assertIsNone(judge(TIMES[:35], TIMES[:35], 1.0))
        self.assertIsNone(judge([5.0] * 100, TIMES[:100], 1.0))


if __name__ == "__main__":
    unittest.main()
