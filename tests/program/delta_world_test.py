#!/usr/bin/env python3
"""A laboratory whose arm is a delta, which states its place: sampled, calibrated, judged by the laboratory's truth, and played on."""
import json
import math
import random
import re
import tomllib
import unittest

from delta import place, readings, tip, turned
from laboratory import LaboratoryTest

WORLD = '[arm]\nmodel = "laboratory-delta"\ngimbal_gain_sd = 0.0\ngimbal_offset_sd_deg = 0.0\n'
HEIGHT = 850.0
MADE = [(2 * math.pi * i / 3, 120.0, 350.0, 800.0, 0.0) for i in range(3)]


def to_chains(p):
    return p[0], p[2], HEIGHT - p[1]


def from_chains(p):
    return p[0], HEIGHT - p[2], p[1]


class DeltaWorld(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.write("world.toml", WORLD)

    def calibrated(self, seed):
        """A rig with an arm that was calibrated on this seed's laboratory, and its truth."""
        self.runs("world", "sample", "arm", "--world", "world.toml", "--seed", str(seed), "--out", f"samples{seed}")
        header = self.read(f"samples{seed}", "arm.csv").decode().splitlines()[0]
        self.assertTrue(header.startswith("arm_x_mm,arm_y_mm,arm_z_mm,"), header)
        self.runs("rig", "new", f"delta{seed}.rig.toml", "--arm", "laboratory-delta")
        self.runs("calibrate", "arm", "--samples", f"samples{seed}/arm.csv", "--rig", f"delta{seed}.rig.toml", "--json", "arm.json")
        text = self.read(f"delta{seed}.rig.toml").decode()
        return text, json.loads(self.read(f"samples{seed}", "truth.json"))

    def test_the_tip_is_known_to_two_tenths_of_a_millimetre(self):
        means = []
        for seed in (1, 2, 3, 4):
            text, truth = self.calibrated(seed)
            means.append(self.mean_error(text, truth))
        self.assertLess(max(means), 0.2, means)

    def mean_error(self, text, truth):
        """mm, of the rig's arm over its workspace."""
        draw = random.Random(3)
        arm = tomllib.loads(text)["arm"]
        built = [tuple(f * chain[key] for f, key in zip((math.pi / 180, 1, 1, 1, math.pi / 180), ("azimuth_deg", "offset_mm", "upper_mm", "lower_mm", "zero_deg")))
                 for chain in truth["chains"]]
        errors, uncorrected = [], []
        for _ in range(300):
            p = [draw.uniform(-150, 150), draw.uniform(0, 250), draw.uniform(-100, 100)]
            stated = from_chains(place(MADE, readings(built, to_chains(p))))
            true = [a + b for a, b in zip(turned(truth["base"]["rotation_qwxyz"], p), truth["base"]["translation_mm"])]
            errors.append(math.dist(tip(arm, stated), true))
            uncorrected.append(math.dist(stated, p))
        mean = sum(errors) / len(errors)
        self.assertGreater(sum(uncorrected) / len(uncorrected), 3 * mean, "there was something to correct")
        return mean

    def test_a_session_calibrates_all_of_it_and_sees_when_it_was_moved(self):
        self.runs("calibrate", "all", "--world", "world.toml", "--seed", "2", "--rig", "all.rig.toml")
        self.runs("world", "sample", "arm", "--world", "world.toml", "--seed", "2", "--points", "5", "--out", "truth")
        self.assertLess(self.mean_error(self.read("all.rig.toml").decode(), json.loads(self.read("truth", "truth.json"))), 0.2)
        self.assertIn("rest_readings_mm", self.read("all.rig.toml").decode())
        self.runs("rig", "check", "all.rig.toml")
        self.runs("lockstep", "--world", "world.toml", "--seed", "2", "--rig", "all.rig.toml", "--seconds", "5", "--quiet", "--json", "played.json")
        registration = json.loads(self.read("played.json"))["registration"]
        self.assertLess(registration["tip_px_rms"], 1.0, registration)
        verify = ("verify", "--quick", "--rig", "all.rig.toml", "--seed", "2", "--world")
        self.runs(*verify, "world.toml")
        self.write("knocked.toml", WORLD + "[knock]\nbase_mm = [0, 0, 3]\n")
        done = self.run_program(*verify, "knocked.toml")
        self.assertEqual(done.code, 1, done)
        self.assertRegex(done.lines[-1], r"has changed since it was calibrated: arm base: .* shifted by [23]\.\d+ mm")

    def test_it_is_played_on_with_forces_through_the_same_guard(self):
        text, _ = self.calibrated(1)
        arm = [part for part in re.split(r"(?m)^(?=\[)", text) if part.startswith(("[arm", "[nominal_arm"))]
        others = [part for part in re.split(r"(?m)^(?=\[)", self.read("rig.toml").decode()) if not part.startswith(("[arm", "[nominal_arm"))]
        self.write("play.rig.toml", "".join(others) + "".join(arm))
        for app in ("touch", "pingpong"):
            self.runs("lockstep", "--world", "world.toml", "--rig", "play.rig.toml", "--app", app, "--seconds", "20", "--quiet", "--json", "delta.json")
            self.runs("lockstep", "--rig", "rig.toml", "--app", app, "--seconds", "20", "--quiet", "--json", "phantom.json")
            delta, phantom = (json.loads(self.read(name))["force"] for name in ("delta.json", "phantom.json"))
            self.assertEqual((delta["fault_ticks"], delta["rejected_blows"], delta["missed_blows"]), (0, 0, 0), app)
            self.assertLessEqual(delta["peak_n"], delta["limit_n"])
            self.assertLess(delta["lost_impulse_rel"], 1e-9)
            # As hard as with the other arm: a hand is a hand.
            self.assertAlmostEqual(delta["peak_n"], phantom["peak_n"], delta=0.5 * phantom["peak_n"])
            self.assertAlmostEqual(delta["blows"], phantom["blows"], delta=3)
        self.refuses(["lockstep", "--world", "world.toml", "--seconds", "1"], 2, "--rig FILE")
        self.refuses(["lockstep", "--world", "world.toml", "--rig", "rig.toml", "--seconds", "1"], 2, "a rig of this laboratory's arm is expected")

    def test_its_forces_are_checked_with_the_laboratorys_hand(self):
        self.calibrated(1)
        for fault, verdict in (("", "agreed"), ("[arm_faults]\nmirrored_axis = 2\n", "axis mirrored")):
            self.write("faulty.toml", WORLD + fault)
            world = self.start_world("--world", "faulty.toml", "--arm-only")
            done = self.run_program("calibrate", "forces", "--arm", "lab", "--rig", "delta1.rig.toml", "--json", "forces.json")
            result = json.loads(self.read("forces.json"))
            self.assertEqual((done.code, result["verdict"]), (0 if verdict == "agreed" else 1, verdict), done)
            self.assertFalse(result["ratios_told"])
            world.send(2)
            world.ends()

    def test_a_laboratory_of_the_other_kind_is_refused_before_anything_is_calibrated(self):
        self.says_no(self.run_program("demo", "--headless", "--world", "world.toml", "--out", "demo"), 2, "the laboratory's arm states its place")
        before = self.files()
        done = self.run_program("calibrate", "all", "--rig", "rig.toml", "--world", "world.toml")
        self.assertEqual(done.code, 2, done)
        self.assertIn("another kind than its [nominal_arm]", done.lines[-1])
        self.assertIn("take [arm] out", done.lines[-1])
        self.assertEqual(self.files(), before)

    def test_places_beyond_the_arms_reach_are_told(self):
        self.runs("world", "sample", "arm", "--world", "world.toml", "--points", "40", "--out", "few")
        self.write("narrow.toml", 'name = "narrow"\ntype = "cartesian"\nrange_mm = [[-60, 60], [-60, 60], [-60, 60]]\n')
        self.assertIn("outside of the reach", self.runs("calibrate", "arm", "--arm", "narrow.toml", "--samples", "few/arm.csv").out)

    def test_a_rig_of_the_other_kind_is_refused_in_real_time(self):
        world = self.start_world("--world", "world.toml", "--arm-only")
        done = self.run_program("physics", "--rig", "rig.toml", "--seconds", "1")
        self.says_no(done, 1, "the device states its place", "is known by its joints")
        self.says_no(self.run_program("sample", "arm", "--arm", "lab", "--tracker", "lab", "--out", "live"), 1, "states its place", "palpate rig new")
        world.send(2)
        world.ends()


if __name__ == "__main__":
    unittest.main()
