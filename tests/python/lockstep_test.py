#!/usr/bin/env python3
"""Sessions on the virtual clock: the program's figures to the last bit, states that agree with them, refusals in words."""
import json
import os
import pathlib
import subprocess
import tempfile
import threading
import unittest
from unittest import mock

import numpy as np

import palpate

PROGRAM = os.environ["PALPATE"]
TOUCH = {"settings": {"touch.stiffness_n_m": 512.3, "touch.colour": "liver"}, "seconds": 4.0}


class LockStep(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.touch = palpate.lockstep("touch", seed=5, **TOUCH)

    def program(self, *arguments):
        figures = self.folder / "figures.json"
        subprocess.run([PROGRAM, *arguments, "--json", str(figures)], capture_output=True, check=True)
        return json.loads(figures.read_text(encoding="utf-8"))

    def test_figures_are_the_programs(self):
        expected = self.program("lockstep", "--app", "touch", "--seed", "5", "--seconds", "4", "--set", "touch.stiffness_n_m=512.3",
                                "--set", "touch.colour=liver")
        self.assertEqual(json.dumps(self.touch.to_dict()), json.dumps(expected))
        self.assertEqual(self.touch.figures["settings"]["touch.stiffness_n_m"], 512.3)

    def test_figures_agree_with_the_states(self):
        figures, states, forces = self.touch.figures, self.touch.states, self.touch.forces
        self.assertEqual(len(states), 4000)
        np.testing.assert_allclose(np.diff(states.log_time_ns), 1e6)
        self.assertEqual(int(states["counters"][-1, 0]), figures["touch"]["touches"])
        self.assertEqual(int(np.sum(states["touching"])), round(1e3 * figures["touch"]["contact_s"]))
        self.assertAlmostEqual(np.linalg.norm(forces["commanded_n"], axis=1).max(), figures["force"]["peak_n"], 9)
        # Counter 5 is the depth below the surface, um.
        self.assertAlmostEqual(1e-3 * states["counters"][states["touching"], 5].max(), figures["touch"]["depth_mm"]["max"], 9)

    def test_events_are_moments_of_the_states(self):
        touching = np.asarray(self.touch.states["touching"], dtype=int)
        begins = 1e-3 * (np.flatnonzero(np.diff(touching, prepend=0) > 0))
        told = [event["time_s"] for event in self.touch.events if event["event"] == "touch-begins"]
        self.assertGreater(len(told), 0)
        np.testing.assert_allclose(told, begins, atol=1e-9)

    def test_the_same_seed_the_same_states_another_seed_others(self):
        again, other = palpate.lockstep("touch", seed=5, **TOUCH), palpate.lockstep("touch", seed=6, **TOUCH)
        self.assertEqual(again.figures, self.touch.figures)
        for name in self.touch.states.columns:
            np.testing.assert_array_equal(again.states[name], self.touch.states[name])
        self.assertNotEqual(other.figures["touch"], self.touch.figures["touch"])

    def test_sessions_side_by_side_are_those_one_after_the_other(self):
        together = [None] * 2

        def play(i):
            together[i] = palpate.lockstep("touch", seed=5, states=False, **TOUCH).figures

        threads = [threading.Thread(target=play, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(together, [self.touch.figures] * 2)

    def test_a_force_that_is_late_comes_late(self):
        late = palpate.lockstep("touch", seed=5, force_delay=0.040, **TOUCH)
        first = next(event["time_s"] for event in late.events if event["event"] == "touch-begins")
        force = np.linalg.norm(late.forces["commanded_n"], axis=1)
        since = (late.forces.log_time_ns - late.states.log_time_ns[0]) / 1e9 - first
        self.assertEqual(force[(since > 0.0) & (since < 0.038)].max(), 0.0)
        self.assertGreater(force[(since > 0.042) & (since < 0.1)].max(), 0.0)
        self.assertGreater(np.linalg.norm(self.touch.forces["commanded_n"], axis=1)[(since > 0.0) & (since < 0.038)].max(), 0.0)

    def test_delays_of_network_and_player_make_play_worse(self):
        def returned(**delays):
            played = [palpate.lockstep("pingpong", seed=seed, seconds=20.0, states=False, **delays).figures["rally"] for seed in (3, 4)]
            return sum(game["returned"] for game in played) / sum(game["serves"] for game in played)

        self.assertLess(returned(player_delay=0.1), returned() - 0.1)

    def test_a_recording_is_kept_where_it_is_asked_for(self):
        file = self.folder / "kept.mcap"
        result = palpate.lockstep("touch", seed=5, record=file, states=False, **TOUCH)
        self.assertIsNone(result.states)
        kept = palpate.Recording(file)
        self.assertEqual((kept.faults, kept["/physics/state"].unread), ((), 0))
        np.testing.assert_array_equal(kept["/physics/state"]["tick"], self.touch.states["tick"])
        with self.assertRaisesRegex(ValueError, "kept.mcap"):
            palpate.lockstep("touch", record=file, **TOUCH)

    def test_what_makes_no_sense_is_told_in_the_settings_own_words(self):
        for words, how in (
                ("touch.stifness_n_m: no such setting; did you mean touch.stiffness_n_m?", {"settings": {"touch.stifness_n_m": 3}}),
                (r"touch.stiffness_n_m: is 1000000; 1 to \d+ is expected", {"settings": {"touch.stiffness_n_m": 1e6}}),
                ("touch.colour: is mauve; one of ", {"settings": {"touch.colour": "mauve"}}),
                ("static_friction: at least friction", {"settings": {"touch.friction": 1.5}}),
                ("no such setting", {"settings": {"ball.mass_kg": 0.003}}),
                ("force_delay", {"force_delay": 5.0}),
                ("seconds", {"seconds": 0.0}),
                ("seconds is nan", {"seconds": float("nan")}),
                ("nowhere.toml", {"world": "nowhere.toml"}),
                ("nowhere.rig.toml", {"rig": "nowhere.rig.toml"})):
            with self.subTest(words), self.assertRaisesRegex((ValueError, FileNotFoundError), words):
                palpate.lockstep("touch", **how)
        with self.assertRaisesRegex(ValueError, "application=nothing: not known"):
            palpate.lockstep("nothing")
        with self.assertRaises(TypeError):
            palpate.lockstep(3)

    def test_a_program_that_is_not_there(self):
        with mock.patch.dict(os.environ, {"PALPATE": "/nowhere/palpate"}), self.assertRaisesRegex(FileNotFoundError, "/nowhere/palpate"):
            palpate.lockstep("touch", **TOUCH)
        with mock.patch.dict(os.environ, {"PALPATE": "/bin/false"}), self.assertRaisesRegex(palpate.Refused, "said nothing"):
            palpate.lockstep("touch", **TOUCH)

    def test_a_study_is_the_programs(self):
        told = palpate.study("tip-noise", runs=8, seed=3, threads=1)
        self.assertEqual(json.dumps(told), json.dumps(self.program("study", "tip-noise", "--runs", "8", "--seed", "3")))
        with self.assertRaisesRegex(ValueError, "no such option"):
            palpate.study("tip-noise", rums=8)


if __name__ == "__main__":
    unittest.main()
