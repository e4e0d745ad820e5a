#!/usr/bin/env python3
"""Results that find no place: a full disk, a folder that is none, a file in the way. What was there before stays."""
import os
import resource
import unittest

from program import ProgramTest, without_phases

POSES = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + "".join(
    f"{i},{x},{y},{z},{w},{a},{b},{c}\n" for i, (x, y, z, w, a, b, c) in enumerate((
        (0, -60, 80, 0.948683298, 0.316227766, 0, 0), (60, 0, 80, 0.948683298, 0, 0.316227766, 0),
        (0, 0, 100, 0.948683298, 0, 0, 0.316227766), (0, 60, 80, 0.948683298, -0.316227766, 0, 0),
        (-60, 0, 80, 0.948683298, 0, -0.316227766, 0))))


def room_for(size):
    """For `before=`: no file can grow beyond `size` bytes, whoever the user is; what a full disk does, too."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


class FullDisk(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("poses.csv", POSES)
        self.pivot = ["calibrate", "pivot", "--poses", "poses.csv"]

    def test_each_output_of_a_calibration_says_that_the_device_is_full(self):
        for option in ("--json", "--out", "--pivots-out"):
            with self.subTest(option):
                self.refuses([*self.pivot, option, "/dev/full"], 1, "/dev/full", "No space left on device", "free some space")

    def test_standard_output_that_cannot_be_written_is_no_success(self):
        for command in (self.pivot, [*self.pivot, "--json", "-"], ["world", "new", "-"], ["apps"], ["--help"]):
            with self.subTest(command), open("/dev/full", "w", encoding="utf-8") as full:
                done = self.run_program(*command, stdout=full)
                self.assertEqual(done.code, 1, done)
                self.assertIn("palpate: standard output: writing failed (No space left on device)", done.lines[-1])

    def test_a_file_that_does_not_fit_is_not_begun(self):
        for command in ([*self.pivot, "--json", "result.json"], ["world", "new", "world.toml"], ["rig", "new", "rig.toml"]):
            with self.subTest(command):
                self.refuses(command, 1, command[-1], "nothing was changed", before=room_for(256))

    def test_a_rig_that_does_not_fit_any_more_stays_as_it_was(self):
        self.runs("rig", "new", "rig.toml")
        self.refuses([*self.pivot, "--rig", "rig.toml"], 1, "rig.toml", "nothing was changed", before=room_for(256))

    def test_samples_that_do_not_fit_are_not_begun(self):
        self.says_no(self.run_program("world", "sample", "pivot", "--out", "samples", before=room_for(4096)), 1, "pivot.csv", "nothing was changed")
        self.assertEqual(set(self.files()), {"poses.csv", "samples"})

    def test_a_demo_that_does_not_fit_leaves_nothing_half_written(self):
        self.says_no(without_phases(self.run_program("demo", "--quick", "--out", "report", before=room_for(4096))), 1, "rig.toml", "free some space")
        for name in self.files():
            self.assertFalse(name.endswith((".json", ".html", ".mp4")) or ".part-" in name, name)
        self.runs("rig", "show", "report/rig.toml")  # as far as it came, it is whole

    def test_a_laboratory_without_room_for_its_memory_does_not_start(self):
        self.says_no(self.run_program("world", "run", "--seconds", "1", before=room_for(4096)), 1, "lab", "bytes of shared memory")
        self.assertEqual([n for n in os.listdir(os.path.join(self.meeting, "palpate")) if not n.endswith(".lock")], [])

    def test_folders_that_cannot_be_and_names_that_are_folders(self):
        self.write("file", "in the way")
        os.mkdir(self.path("folder"))
        for folder in ("file", "file/below", "/proc/palpate-report"):  # nobody makes a folder in /proc, not even root
            for command in (["demo", "--quick", "--out"], ["world", "sample", "pivot", "--out"]):
                with self.subTest(folder=folder, command=command):
                    self.refuses([*command, folder], 2, folder, "cannot be created")
        for option in ("--json", "--out", "--pivots-out"):
            with self.subTest(option):
                self.refuses([*self.pivot, option, "folder"], 2, "folder", "a file name is expected")
        self.refuses([*self.pivot, "--json", "nowhere/result.json"], 2, "nowhere", "create it first")
        self.refuses([*self.pivot, "--json", "/proc/result.json"], 2, "/proc/result.json", "cannot be written")

    def test_new_files_do_not_replace_old_ones(self):
        self.write("file", "in the way")
        self.refuses(["world", "new", "file"], 2, "exists already")
        self.refuses(["rig", "new", "file"], 2, "file", "--force")


if __name__ == "__main__":
    unittest.main()
