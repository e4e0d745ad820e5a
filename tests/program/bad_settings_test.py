#!/usr/bin/env python3
"""Rig, world and arm model files that are missing or wrong: file and line are named, and nothing is started or written."""
import unittest

from program import ProgramTest


def with_line(text, before, line):
    """The text with a line put in before the first that begins with `before`, and its number."""
    lines = text.splitlines()
    at = next(i for i, content in enumerate(lines) if content.startswith(before))
    return "\n".join([*lines[:at], line, *lines[at:]]) + "\n", at + 1


class BadSettings(ProgramTest):
    good = {}  # of what the program itself writes, asked once

    def setUp(self):
        super().setUp()
        if not self.good:
            self.runs("rig", "new", "good.toml")
            self.good.update(rig=self.read("good.toml").decode(), world=self.runs("world", "new", "-").out)
        self.rig, self.world = self.good["rig"], self.good["world"]
        self.write("good.toml", self.rig)
        self.poses = self.write("poses.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,1,2,3,1,0,0,0\n")

    def rig_readers(self):
        yield "rig", "show"
        yield "physics", "--rig"
        yield "graphics", "--rig"
        yield "calibrate", "all", "--rig"
        yield "calibrate", "pivot", "--poses", self.poses, "--rig"

    def world_readers(self):
        yield "world", "show"
        yield "world", "run", "--world"
        yield "world", "sample", "pivot", "--out", "samples", "--world"
        yield "demo", "--out", "report", "--world"
        yield "calibrate", "all", "--rig", "new.toml", "--world"
        yield "study", "points", "--runs", "1", "--world"

    def refuses_all(self, readers, *words):
        for command in readers:
            with self.subTest(command):
                self.refuses([*command, "bad.toml"], 2, "bad.toml", *words)

    def test_a_missing_rig_is_named(self):
        for command in self.rig_readers():
            if command[:2] != ("calibrate", "all"):  # which makes it
                with self.subTest(command):
                    self.refuses([*command, "nowhere.toml"], 2, "nowhere.toml: no such file; ", "palpate rig new")

    def test_an_unknown_key_of_a_rig_is_named_with_file_line_and_the_nearest_known_one(self):
        text, number = with_line(self.rig, "leds_mm", "led_mm = []")
        self.write("bad.toml", text)
        self.refuses_all(self.rig_readers(), f"bad.toml:{number}: ", "unknown key", ".led_mm'", "did you mean 'leds_mm'?")

    def test_a_missing_world_is_named(self):
        for command in self.world_readers():
            with self.subTest(command):
                self.refuses([*command, "nowhere.toml"], 2, "nowhere.toml: no such file")

    def test_an_unknown_key_of_a_world_is_named_with_file_line_and_the_nearest_known_one(self):
        text, number = with_line(self.world, "rate_hz", "rate_hertz = 100")
        self.write("bad.toml", text)
        self.refuses_all(self.world_readers(), f"bad.toml:{number}: ", "unknown key 'world.rate_hertz'", "did you mean 'rate_hz'?")

    def test_a_world_file_in_a_rigs_place_and_the_other_way_round_are_told_apart(self):
        self.write("bad.toml", self.world)
        self.refuses_all(self.rig_readers(), "bad.toml: is a world file", "a rig file is expected", "`palpate rig new FILE`")
        self.write("bad.toml", self.rig)
        self.refuses_all(self.world_readers(), "bad.toml: is a rig file", "a world file is expected", "`palpate world new FILE`")

    def test_an_unknown_part_of_a_world_is_named(self):
        self.write("bad.toml", self.world + "[robot]\nlegs = 2\n")
        self.refuses(["world", "show", "bad.toml"], 2, f"bad.toml:{len(self.world.splitlines()) + 1}: ", "unknown key 'robot'")

    def test_what_is_not_toml_is_named_with_its_line(self):
        for text, commands in ((self.rig, ["rig", "show"]), (self.world, ["world", "show"])):
            self.write("bad.toml", text + "half a line\n")
            self.refuses([*commands, "bad.toml"], 2, f"bad.toml:{len(text.splitlines()) + 1}: ", "not valid TOML")

    def test_nan_and_words_in_place_of_numbers_are_named_with_their_line(self):
        for value, words in (("nan", "a finite number is expected"), ('"fast"', "a number is expected"), ("-5", "is expected")):
            text, number = with_line(self.world, "rate_hz", f"rate_hz = {value}")
            lines = text.splitlines()
            del lines[number]  # the right one
            self.write("bad.toml", "\n".join(lines) + "\n")
            self.refuses(["world", "show", "bad.toml"], 2, f"bad.toml:{number}: ", "world.rate_hz", words)

    def test_a_bad_arm_model_is_named(self):
        samples = self.write("arm.csv", "joint_1_deg,joint_2_deg,x_mm,y_mm,z_mm\n1,2,3,4,5\n")
        command = ["calibrate", "arm", "--samples", samples, "--json", "result.json", "--arm"]
        self.refuses([*command, "nowhere.toml"], 2, "nowhere.toml")
        self.write("bad.toml", 'type = "dh"\n[[joint]]\na_mm = 1.0\nalpha_deg = 0.0\nd_mm = nan\ntheta_offset_deg = 0.0\n')
        self.refuses([*command, "bad.toml"], 2, "bad.toml:5: ", "nan")
        self.write("bad.toml", 'type = "dh"\n[[joint]]\na_mm = 1.0\nalpha_deg = 0.0\nd_mm = 0.0\ntheta_deg = 0.0\n')
        self.refuses([*command, "bad.toml"], 2, "bad.toml:", "theta_offset_deg")

    def test_a_rig_without_calibrations_starts_no_server(self):
        self.refuses(["physics", "--rig", "good.toml"], 1, "good.toml", "arm calibration", "calibrate arm")
        self.refuses(["graphics", "--rig", "good.toml"], 1, "good.toml", "calibrate all")
        self.assertEqual(self.run_program("rig", "check", "good.toml").code, 1)

    def test_unknown_options_values_and_commands_are_wrong_use(self):
        for command in (["calibrate", "pivot"], ["calibrate", "pivot", "--poses", "x", "--method", "magic"], ["demo", "--app", "golf"],
                        ["demo", "--seconds", "nan"], ["calibrate", "pivot", "--poses", self.poses, "--tip-mm", "1,inf,3"], ["world", "sample", "pivot", "--out", "x", "--points", "-1"], ["nothing"], [],
                        ["physics", "--rig", "good.toml", "--physics-hz", "5"]):
            with self.subTest(command):
                self.refuses(command, 2)
        self.refuses(["--fast"], 2, "--fast: no such option")
        self.refuses(["rig", "--fast=2"], 2, "--fast=2: no such option of 'rig'")
        self.refuses(["rig", "check", "good.toml", "--rest-readings", "1,2,3", "--rest-tolerance-deg", "-1"], 2, "--rest-tolerance-deg")

    def test_a_misspelt_or_missing_option_or_command_is_answered_with_those_there_are(self):
        self.refuses(["demo", "--stero"], 2, "--stero: no such option of 'demo'; did you mean --stereo?")
        self.refuses(["demo", "--secods=3", "--quick"], 2, "--secods=3: no such option of 'demo'; did you mean --seconds?")
        self.refuses(["calibrate", "pivot", "--pose", self.poses], 2, "--pose: no such option of 'calibrate pivot'; did you mean --poses?")
        # Short names are not like each other because of their dashes.
        said = self.run_program("recording", "export", "s.mcap", "--out", "x")
        self.says_no(said, 2, "--out: no such option of 'recording export'")
        self.assertNotIn("did you mean", said.lines[0])
        self.refuses(["--verson"], 2, "--verson: no such option of 'palpate'; did you mean --version?")
        self.refuses(["demmo"], 2, "demmo: no such command; did you mean 'demo'?")
        self.refuses(["calibrate", "pivto", "--poses", self.poses], 2, "pivto: no such command; did you mean 'pivot'?")
        for far in (["demo", "--weather", "3"], ["fly"], ["calibrate", "everything"]):  # like nothing there is
            with self.subTest(far):
                done = self.run_program(*far)
                self.says_no(done, 2, "no such", "; see --help")
                self.assertNotIn("did you mean", done.err)
        self.refuses([], 2, "'palpate' expects a command; one of calibrate, demo, ")
        self.refuses(["rig"], 2, "'rig' expects a command; one of new, ")
        self.refuses(["demo", "--quick", "golf"], 2, "golf: 'demo' takes no such word; leave it out")
        self.refuses(["calibrate", "camera", "--images", "good.toml", "good.toml", "--board", "9x6"], 2, "takes no such word; a pattern of files is written in quotes")

    def test_what_is_written_as_png_is_called_png(self):
        for name in ("x.jpg", "x", "x.png.txt"):
            self.refuses(["picture", "--out", name], 2, f"--out '{name}'", "ends in .png is expected")

    def test_numbers_out_of_range_are_named_before_anything_is_read(self):
        for option, value in (("--seed", "-1"), ("--seed", "9" * 23), ("--seconds", "-3")):
            command = ["demo"] if option == "--seed" else ["physics", "--rig", "absent.toml"]
            with self.subTest(option=option, value=value):
                self.refuses([*command, option, value], 2, option)
        self.refuses(["demo", "--seed", "-1"], 2, "--seed '-1': is below zero; a whole number from 0 on is expected, such as 1")
        self.refuses(["demo", "--seed", "9" * 23], 2, "is too large; a whole number of at most 19 digits is expected")
        self.refuses(["demo", "--seed", "1.5"], 2, "--seed '1.5': a whole number from 0 on is expected, such as 1")
        self.refuses(["demo", "--seconds", "soon"], 2, "--seconds 'soon': a number is expected, such as 1.5")
        self.refuses(["demo", "--seconds", "nan"], 2, "--seconds")
        self.refuses(["physics", "--rig", "good.toml", "--haptic-hz", "500"], 2, "--haptic-hz: '500'; 1000 to 4000 is expected")
        self.refuses(["study", "points", "--runs", "0"], 2, "--runs: '0'; 1 to 1000000 is expected")
        self.refuses(["tracker", "replay", self.poses, "--speed", "-1"], 2, "--speed: '-1'; ")

    def test_a_word_that_is_none_of_the_choices_is_answered_with_them(self):
        self.refuses(["world", "sample", "pivto", "--out", "x"], 2, "'pivto'; one of ", "did you mean pivot?")
        self.refuses(["calibrate", "pivot", "--poses", self.poses, "--method", "magic"], 2, "'magic'; one of algebraic, sphere, robust is expected")

    def test_help_is_a_command_as_well(self):
        self.assertEqual(self.runs("help").out, self.runs("--help").out)
        self.assertEqual(self.runs("help", "calibrate", "arm").out, self.runs("calibrate", "arm", "--help").out)
        self.assertIn("1000 to 4000", self.runs("help", "physics").out)


if __name__ == "__main__":
    unittest.main()
