#!/usr/bin/env python3
"""Data that are well formed and cannot carry an answer: refused with the reason, exit 1, nothing written."""
import json
import math
import os
import unittest

from program import ProgramTest

POSES = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
POINTS = "x_mm,y_mm,z_mm\n"
# Rotations about x, y and z by turns, as rough as hand-written numbers; the tip at (0, 0, -100) mm rests in the origin.
TURNS = ((0.966, 0.259, 0, 0), (0.966, 0, 0.259, 0), (0.966, 0, 0, 0.259), (0.966, -0.259, 0, 0), (0.966, 0, -0.259, 0))


def poses(turns):
    rows = []
    for i, (w, x, y, z) in enumerate(turns):
        size = w * w + x * x + y * y + z * z
        up = [2 * (x * z + w * y) / size, 2 * (y * z - w * x) / size, 1 - 2 * (x * x + y * y) / size]
        rows.append(",".join(map(str, [i / 10, *(100 * u for u in up), w, x, y, z])) + "\n")
    return POSES + "".join(rows)


def in_metres(table):
    """The same lengths under the same names."""
    header, *rows = table.splitlines()
    scale = [0.001 if name.endswith("_mm") else None for name in header.split(",")]
    rows = [",".join(str(by * float(cell)) if by and cell else cell for by, cell in zip(scale, row.split(","))) for row in rows]
    return "\n".join([header, *rows]) + "\n"


class WeakData(ProgramTest):
    def refuses_pivot(self, content, *words):
        self.write("poses.csv", content)
        for method in ("algebraic", "sphere", "robust"):
            with self.subTest(method):
                self.refuses(["calibrate", "pivot", "--poses", "poses.csv", "--method", method, "--json", "result.json", "--pivots-out",
                              "pivots.csv", "--out", "part.toml"], 1, "poses.csv: ", "pivot", *words)

    def test_the_same_poses_are_enough_once_there_are_some(self):
        self.write("poses.csv", poses(TURNS))
        self.runs("calibrate", "pivot", "--poses", "poses.csv", "--json", "result.json")

    def test_a_pivot_from_too_few_poses(self):
        self.refuses_pivot(poses(TURNS[:2]), "2 poses", "at least 4 are needed")
        self.refuses_pivot(poses(TURNS[:1]) + poses(TURNS[:1]).split("\n", 1)[1] * 49, "1 pose", "49 rows repeat earlier ones")

    def test_a_pivot_without_rotation(self):
        still = POSES + "".join(f"{i},{i % 7},{i % 5},{i % 3},1,0,0,0\n" for i in range(50))
        self.refuses_pivot(still, "turns by 0.0 deg", "at least 10 deg", "swing")
        # Several pivots in one file are no cause of it.
        self.assertNotIn("--segments", self.run_program("calibrate", "pivot", "--poses", "poses.csv").err)

    def test_a_pivot_turned_about_one_axis_only(self):
        turns = [0.03 * i for i in range(30)]
        self.refuses_pivot(poses([(math.cos(t), math.sin(t), 0, 0) for t in turns]), "axis")

    def test_points_on_a_line(self):
        self.write("line.csv", POINTS + "".join(f"{i},{2 * i},{3 * i}\n" for i in range(6)))
        self.write("turned.csv", POINTS + "".join(f"{-2 * i},{i},{3 * i}\n" for i in range(6)))
        self.refuses(["calibrate", "points", "--from", "line.csv", "--to", "turned.csv", "--json", "result.json"], 1, "on a line", "beside")

    def test_two_points_and_lists_of_unlike_length(self):
        self.write("two.csv", POINTS + "0,0,0\n1,0,0\n")
        self.write("three.csv", POINTS + "0,0,0\n1,0,0\n0,1,0\n")
        self.refuses(["calibrate", "points", "--from", "two.csv", "--to", "two.csv"], 1, "2 points", "at least 3")
        self.warned("holds the same as", "calibrate", "points", "--from", "three.csv", "--to", "three.csv")
        self.refuses(["calibrate", "points", "--from", "two.csv", "--to", "three.csv"], 2, "two.csv", "three.csv", "same length")

    def test_a_surface_of_two_corners_or_of_corners_on_a_line(self):
        self.write("two.csv", POINTS + "0,0,0\n1000,0,0\n")
        self.refuses(["calibrate", "surface", "--points", "two.csv", "--out", "part.toml"], 1, "2 points", "four corners")
        self.write("line.csv", POINTS + "0,0,0\n500,0,0\n1000,0,0\n1500,0,0\n")
        self.refuses(["calibrate", "surface", "--points", "line.csv", "--out", "part.toml"], 1, "lie on a line")

    def test_hand_and_eye_that_do_not_meet_in_time_or_do_not_turn(self):
        self.write("early.csv", POSES + "".join(f"{i},{i},0,0,1,0,0,0\n" for i in range(30)))
        self.write("late.csv", POSES + "".join(f"{1000 + i},{i},0,0,1,0,0,0\n" for i in range(30)))
        self.write("between.csv", POSES + "".join(f"{0.5 + i},{i},0,0,1,0,0,0\n" for i in range(29)))
        command = ["calibrate", "hand-eye", "--json", "result.json", "--hand", "early.csv", "--eye"]
        self.refuses([*command, "late.csv"], 1, "hand-eye", "--estimate-delay")
        self.refuses([*command, "between.csv"], 1, "hand-eye")

    def test_two_recordings_without_one_delay(self):
        def table(name, header, begin, value):
            times = [begin + 0.02 * i for i in range(1000)]
            self.write(name, header + "\n" + "".join(f"{t},{value(t - begin)}\n" for t in times))

        def motion(t):
            return sum(math.sin(rate * t + rate * rate) for rate in (0.7, 1.9, 3.1, 4.3, 5.9))

        table("number.csv", "time_s,u_px,level", 0, lambda t: f"{640 - 100 * motion(t)},7")
        table("place.csv", "time_s,x_mm,y_mm,z_mm", 0.25, lambda t: f"{50 * motion(t)},{20 * math.sin(t)},0")
        command = ["calibrate", "delay", "--json", "result.json", "--from", "number.csv", "--to", "place.csv"]
        self.refuses(command, 2, "number.csv: ", "neither poses", "--from-column", "u_px, level")
        self.refuses([*command, "--from-column", "v_px"], 2, "number.csv: ", "'v_px'", "time_s,u_px,level")
        self.refuses([*command, "--from-column", "level"], 1, "number.csv", "does not change")
        self.runs(*command, "--from-column", "u_px")
        found = json.loads(self.read("result.json"))
        self.assertAlmostEqual(found["delay_s"], 0.25, delta=1e-3)
        self.assertGreater(found["correlation"], 0.999)
        os.remove(self.path("result.json"))
        table("swing.csv", "time_s,u_px", 0, lambda t: f"{math.sin(4 * t)}")
        table("swing_late.csv", "time_s,u_px", 0.3, lambda t: f"{math.sin(4 * t)}")
        columns = ["--from-column", "u_px", "--to-column", "u_px"]
        swings = ["calibrate", "delay", "--json", "result.json", "--from", "swing.csv", "--to", "swing_late.csv", *columns]
        self.refuses(swings, 1, "repeats itself", "1.08")
        self.refuses(swings, 1, "--longest-s")
        self.runs(*swings, "--longest-s", "0.4")
        table("other.csv", "time_s,u_px", 0.3, lambda t: f"{sum(math.sin(rate * t + 5 * rate) for rate in (0.9, 2.3, 3.7, 5.1))}")
        self.refuses([*command[:-1], "other.csv", *columns], 1, "no common time span", "0.300 to 20.280 s")
        self.refuses([*command[:-1], "number.csv", *columns], 2, "holds the same")

    def test_an_arm_from_two_samples(self):
        self.write("arm.csv", "joint_1_deg,joint_2_deg,joint_3_deg,x_mm,y_mm,z_mm\n1,2,3,4,5,6\n2,3,4,5,6,7\n")
        self.refuses(["calibrate", "arm", "--samples", "arm.csv", "--arm", "phantom-premium-1.5", "--json", "result.json"], 1, "arm")

    def test_an_arm_that_did_not_make_these_samples(self):
        self.runs("world", "sample", "arm", "--points", "70", "--out", "sim")
        header, *rows = self.read("sim", "arm.csv").decode().splitlines()
        command = ["calibrate", "arm", "--samples", "odd.csv", "--arm", "phantom-premium-1.5", "--json", "result.json"]
        cells = [row.split(",") for row in rows]
        odd = {"joints": (header, [[c[1], c[0], *c[2:]] for c in cells]),
               "rows": (header, [[*a[:3], *b[3:]] for a, b in zip(cells, cells[17:] + cells[:17])]),
               "angles": (header.replace("_deg", "_rad"), cells),
               "places": (header.replace("_mm,", "_m,"), cells)}
        for name, (columns, table) in odd.items():
            with self.subTest(name):
                self.write("odd.csv", "\n".join([columns, *map(",".join, table)]) + "\n")
                self.refuses(command, 1, "odd.csv", "off the best fit", "check the units")
        metres = [[str(float(cell) / 1000) if name.startswith("marker_") and name.endswith("_mm") else cell
                   for name, cell in zip(header.split(","), row)] for row in cells]
        radians = [[str(math.radians(float(cell))) if name.endswith("_deg") else cell for name, cell in zip(header.split(","), row)] for row in cells]
        for name, table in {"numbers in metres": metres, "numbers in radians": radians}.items():
            with self.subTest(name):
                self.write("odd.csv", "\n".join([header, *map(",".join, table)]) + "\n")
                self.refuses(command, 1, "odd.csv: arm: ", "check the units")
        self.write("odd.csv", "\n".join([header, *rows]) + "\n")
        self.assertNotIn("is it a", self.runs(*command).out)
        self.write("longer.toml", 'type = "phantom"\nlengths_mm = [260, 260]\n')
        self.warned("is it a longer", *command[:-3], "longer.toml")

    def test_a_tip_that_the_arms_samples_contradict(self):
        self.runs("world", "sample", "arm", "--points", "70", "--out", "sim")
        command = ["calibrate", "arm", "--samples", "sim/arm.csv", "--arm", "phantom-premium-1.5"]
        self.runs(*command, "--json", "found.json")
        true = json.loads(self.read("found.json"))["tip_mm"]
        near = self.runs(*command, "--tip-mm", ",".join(str(value + 1) for value in true)).out
        self.assertNotIn("from the given one", near)
        self.warned("mm from the given one", *command, "--tip-mm", ",".join(str(value + 20) for value in true))
        self.refuses([*command, "--tip-mm", "500,-700,900", "--json", "result.json"], 1, "the given tip", "contradict it",
                     "(500.0, -700.0, 900.0) mm")

    def test_rows_that_stand_there_twice_count_once_and_are_told(self):
        for kind, options in {"pivot": ["--poses"], "arm": ["--arm", "phantom-premium-1.5", "--samples"], "surface": ["--points"]}.items():
            with self.subTest(kind):
                self.runs("world", "sample", kind, "--points", "40", "--out", kind)
                text = self.read(kind, f"{kind}.csv").decode()
                self.write("once.csv", text)
                self.write("twice.csv", text + text.split("\n", 1)[1])
                command = ["calibrate", kind, *options]
                once, twice = (json.loads(self.runs(*command, file, "--json", "-").out) for file in ("once.csv", "twice.csv"))
                self.assertEqual(once["std"], twice["std"])
                self.assertTrue(any("repeat" in w for w in twice["warnings"]), twice["warnings"])
                self.assertFalse(any("repeat" in w for w in once["warnings"]), once["warnings"])

    def test_test_samples_that_were_trained_on_are_told(self):
        self.runs("world", "sample", "arm", "--points", "40", "--out", "sim")
        done = self.runs("calibrate", "arm", "--arm", "phantom-premium-1.5", "--samples", "sim/arm.csv", "--test", "sim/arm.csv")
        self.assertIn("40 rows of sim/arm.csv stand among the samples too", done.out)

    def test_the_same_file_as_hand_and_eye(self):
        self.write("poses.csv", poses(TURNS))
        self.refuses(["calibrate", "hand-eye", "--hand", "poses.csv", "--eye", "poses.csv"], 2, "holds the same")

    def test_a_pivot_file_of_several_pivots_names_its_column(self):
        rows = poses(TURNS).splitlines()
        moved = [",".join([c[0], str(float(c[1]) + 300), *c[2:]]) for c in (row.split(",") for row in rows[1:])]
        self.write("poses.csv", "\n".join([rows[0] + ",segment", *(row + ",1" for row in rows[1:]), *(row + ",2" for row in moved)]) + "\n")
        self.refuses(["calibrate", "pivot", "--poses", "poses.csv", "--json", "result.json"], 1, "no resting tip", "--segments segment")
        self.runs("calibrate", "pivot", "--poses", "poses.csv", "--segments", "segment")

    def test_landmarks_before_any_surface_and_dots_of_one_name(self):
        self.runs("rig", "new", "rig.toml")
        self.write("dots.csv", "label,x_mm,y_mm,z_mm\na,0,0,0\na,200,0,0\n")
        command = ["calibrate", "landmarks", "--points", "dots.csv", "--rig", "rig.toml"]
        self.refuses(command, 1, "dots.csv", "calibrate surface first")
        self.write("corners.csv", POINTS + "0,0,0\n500,0,0\n500,500,0\n0,500,0\n")
        self.runs("calibrate", "surface", "--points", "corners.csv", "--name", "table", "--rig", "rig.toml")
        self.refuses(command, 1, "dots.csv", "label two dots differently")
        self.write("dots.csv", "label,x_mm,y_mm,z_mm\na,100,100,0\na,100.4,100,0\nb,200,100,0\n")
        self.runs(*command)

    def test_terms_that_a_rig_file_does_not_hold(self):
        self.runs("rig", "new", "rig.toml")
        self.runs("world", "sample", "arm", "--points", "70", "--out", "sim")
        self.refuses(["calibrate", "arm", "--samples", "sim/arm.csv", "--rig", "rig.toml", "--free", "gains,offsets,quadratic"], 2, "--free", "quadratic", "--json")

    def warned(self, words, *command):
        done = self.runs(*command)
        self.assertIn(words, done.out)

    def test_data_that_only_a_mistake_explains_are_warned_of(self):
        for kind in ("arm", "pivot", "surface", "hand-eye"):
            self.runs("world", "sample", kind, *([] if kind == "hand-eye" else ["--points", "70"]), "--out", kind)
        arm = self.read("arm", "arm.csv").decode()
        self.write("gimbal.csv", arm.replace("gimbal_1", "gimbal_x").replace("gimbal_3", "gimbal_1").replace("gimbal_x", "gimbal_3"))
        self.warned("off its marker", "calibrate", "arm", "--arm", "phantom-premium-1.5", "--samples", "gimbal.csv")
        joints = arm.replace("joint_2", "joint_x").replace("joint_3", "joint_2").replace("joint_x", "joint_3")
        self.write("joints.csv", joints.replace("gimbal_", "unused_"))
        self.warned("the order of the joints right", "calibrate", "arm", "--arm", "phantom-premium-1.5", "--samples", "joints.csv")
        self.runs("world", "sample", "arm", "--seed", "7", "--points", "30", "--out", "other")
        self.warned("are they of this arm", "calibrate", "arm", "--arm", "phantom-premium-1.5", "--samples", "arm/arm.csv", "--test", "other/arm.csv")
        self.write("swapped.csv", self.read("hand-eye", "hand.csv").decode().replace("x_mm,y_mm", "y_mm,x_mm", 1))
        self.refuses(["calibrate", "hand-eye", "--hand", "swapped.csv", "--eye", "hand-eye/eye.csv", "--estimate-delay", "--json", "result.json"], 1,
                     "the order and signs of x, y and z")
        metres = {}
        for kind in ("pivot", "surface"):
            metres[kind] = self.write(f"{kind}_m.csv", in_metres(self.read(kind, f"{kind}.csv").decode()))
        self.warned("check the unit", "calibrate", "pivot", "--poses", metres["pivot"])
        self.warned("check the unit", "calibrate", "surface", "--points", metres["surface"])
        header, *eye = self.read("hand-eye", "eye.csv").decode().splitlines()
        self.write("short.csv", "\n".join([header, *eye[:60]]) + "\n")
        self.warned("little to find a delay by", "calibrate", "hand-eye", "--hand", "hand-eye/hand.csv", "--eye", "short.csv", "--estimate-delay")
        cells = [row.split(",", 1) for row in eye]
        self.write("epoch.csv", "\n".join([header, *(f"{float(time) + 1.7e9:.4f},{rest}" for time, rest in cells)]) + "\n")
        self.warned("clocks have different origins", "calibrate", "hand-eye", "--hand", "hand-eye/hand.csv", "--eye", "epoch.csv", "--estimate-delay",
                    "--out", "epoch.toml")
        self.assertNotIn("camera_after_tracker_s", self.read("epoch.toml").decode())
        self.runs("calibrate", "hand-eye", "--hand", "hand-eye/hand.csv", "--eye", "hand-eye/eye.csv", "--estimate-delay", "--out", "one_clock.toml")
        self.assertIn("camera_after_tracker_s", self.read("one_clock.toml").decode())
        self.write("arm_m.csv", in_metres(arm))
        self.refuses(["calibrate", "arm", "--arm", "phantom-premium-1.5", "--samples", "arm_m.csv"], 1, "the measured places lie 0.17 mm rms", "check the units in the header")
        self.write("corners.csv", POINTS + "0,0,0\n750,0,0\n790,1000,0\n0,1000,0\n")
        self.warned("touched wrongly", "calibrate", "surface", "--points", "corners.csv")

    def test_eye_poses_turned_round_or_in_metres_are_refused(self):
        self.runs("world", "sample", "hand-eye", "--out", "sim")
        self.runs("convert", "sim/eye.csv", "round.csv", "--invert")
        header, *rows = self.read("sim", "eye.csv").decode().splitlines()
        names = header.split(",")
        metres = [",".join(str(float(cell) / 1000) if name.endswith("_mm") else cell for name, cell in zip(names, row.split(","))) for row in rows]
        self.write("metres.csv", "\n".join([header, *metres]) + "\n")
        command = ["calibrate", "hand-eye", "--hand", "sim/hand.csv", "--json", "result.json"]
        for delay in ([], ["--estimate-delay"]):
            self.refuses([*command, *delay, "--eye", "round.csv"], 1, "round.csv", "the board's in the camera", "palpate convert --invert")
            self.refuses([*command, *delay, "--eye", "metres.csv"], 1, "metres.csv", "1e+03 times as long", "check the headers")

    def test_a_tip_known_worse_than_the_rigs_is_told(self):
        self.runs("rig", "new", "rig.toml")
        self.runs("world", "sample", "pivot", "--out", "sim")
        good = self.runs("calibrate", "pivot", "--poses", "sim/pivot.csv", "--rig", "rig.toml")
        self.assertNotIn("it holds this one now", good.out)
        self.assertNotIn("swing it further", good.out)
        wobble = [(7 * math.sin(7 * i), 7 * math.cos(5 * i), 4 * math.sin(3 * i)) for i in range(40)]
        few = poses([(math.cos(0.1), math.sin(0.1) * math.sin(i), math.sin(0.1) * math.cos(i), 0) for i in range(40)]).splitlines()
        rows = [",".join([c[0], *(str(float(a) + b) for a, b in zip(c[1:4], w)), *c[4:]]) for c, w in zip((r.split(",") for r in few[1:]), wobble)]
        self.write("poor.csv", "\n".join([few[0], *rows]) + "\n")
        poor = self.runs("calibrate", "pivot", "--poses", "poor.csv", "--rig", "rig.toml")
        self.assertIn("swing it further", poor.out)
        self.assertIn("the rig file knew this tip to 0.", poor.out)

    def test_hand_and_eye_exchanged_and_a_delay_nobody_asked_for_are_told(self):
        for seed in (1, 2, 3):
            self.runs("world", "sample", "hand-eye", "--seed", seed, "--out", "sim")
            hand, eye = "sim/hand.csv", "sim/eye.csv"
            command = ["calibrate", "hand-eye"]
            right = self.runs(*command, "--hand", hand, "--eye", eye, "--estimate-delay")
            self.assertNotIn("warning", right.out)
            self.warned("hand and eye seem to be exchanged", *command, "--hand", eye, "--eye", hand, "--estimate-delay")
            self.warned("in place of 0.0000 s", *command, "--hand", hand, "--eye", eye)
            known = json.loads(self.read("sim/truth.json"))["delay_s"]
            self.assertNotIn("warning", self.runs(*command, "--hand", hand, "--eye", eye, "--delay-s", known).out)

    def test_times_under_another_name_are_not_passed_over(self):
        """Without times rows are pairs by their number, and these are not each other's."""
        self.runs("world", "sample", "hand-eye", "--out", "sim")
        for name in ("hand", "eye"):
            self.write(f"{name}.csv", self.read("sim", f"{name}.csv").decode().replace("time_s", "timestamp", 1))
        self.refuses(["calibrate", "hand-eye", "--hand", "hand.csv", "--eye", "eye.csv", "--json", "result.json"], 2, "hand.csv", "'timestamp'", "rename it")

    def test_a_board_of_more_corners_than_told_and_squares_in_metres_are_told(self):
        images = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "opencv_chessboard_left", "left0*.jpg")
        command = ["calibrate", "camera", "--images", images, "--square-mm"]
        right = self.runs(*command, "25", "--board", "9x6")
        self.assertNotIn("goes on", right.out)
        self.assertNotIn("metres", right.out)
        self.warned("the chessboard goes on beyond --board 8x6", *command, "25", "--board", "8x6")
        self.warned("--square-mm 0.025 looks like metres", *command, "0.025", "--board", "9x6")

    def test_points_far_off_and_lists_of_two_sizes_are_told(self):
        place = [(97 * i % 500, 61 * i % 300, 37 * i % 200) for i in range(50)]
        self.write("from.csv", POINTS + "".join(f"{x},{y},{z}\n" for x, y, z in place))
        noise = [(0.3 * math.sin(7 * i), 0.3 * math.cos(11 * i), 0.3 * math.sin(5 * i)) for i in range(50)]
        for file, size, off in (("to.csv", 1, 0), ("stray.csv", 1, 50), ("larger.csv", 1.1, 0)):
            self.write(file, POINTS + "".join(f"{size * x + a + off * (i == 20)},{size * y + b},{size * z + c}\n"
                                              for i, ((x, y, z), (a, b, c)) in enumerate(zip(place, noise))))
        points = ["calibrate", "points", "--from", "from.csv", "--to"]
        self.assertNotIn("warning", self.runs(*points, "to.csv").out)
        self.warned("1 point lies far off what suits the others: '21' by 4", *points, "stray.csv")
        self.warned("the second list is 1.100", *points, "larger.csv")

    def test_a_photograph_under_two_names_counts_once_and_is_told(self):
        self.runs("world", "sample", "camera", "--out", "camera")
        header, *rows = self.read("camera", "corners.csv").decode().splitlines()
        first = rows[0].split(",")[0]
        again = ["copy," + row.split(",", 1)[1] for row in rows if row.split(",")[0] == first]
        self.write("more.csv", "\n".join([header, *rows, *again]) + "\n")
        once, twice = (json.loads(self.runs("calibrate", "camera", "--corners", file, "--json", "-").out) for file in ("camera/corners.csv", "more.csv"))
        self.assertEqual(once["std"], twice["std"])
        self.assertTrue(any("the same photograph twice" in w for w in twice["warnings"]), twice["warnings"])

    def test_samples_that_do_not_fit_are_counted(self):
        self.runs("world", "sample", "arm", "--points", "40", "--out", "sim")
        header, *rows = self.read("sim", "arm.csv").decode().splitlines()
        at = header.split(",").index("marker_x_mm")
        cells = rows[7].split(",")
        cells[at] = str(float(cells[at]) + 30)
        self.write("arm.csv", "\n".join([header, *rows[:7], ",".join(cells), *rows[8:]]) + "\n")
        self.warned("1 of 40 samples, which do not fit", "calibrate", "arm", "--arm", "phantom-premium-1.5", "--samples", "arm.csv")

    def test_results_apart_and_the_rig_as_it_was_where_another_result_fails(self):
        self.runs("rig", "new", "rig.toml")
        self.write("poses.csv", poses(TURNS))
        command = ["calibrate", "pivot", "--poses", "poses.csv"]
        self.refuses([*command, "--json", "poses.csv"], 2, "poses.csv", "a file of its own")
        self.refuses([*command, "--rig", "rig.toml", "--json", self.path("rig.toml")], 2, "a file of its own")
        self.refuses([*command, "--json", "a", "--out", "./a"], 2, "a file of its own")
        self.refuses([*command, "--rig", "rig.toml", "--json", "/nowhere/result.json"], 2, "/nowhere")
        self.refuses([*command, "--rig", "rig.toml", "--out", "/nowhere/part.toml"], 2, "/nowhere")
        self.refuses([*command, "--rig", ""], 2, "--rig", "empty")
        self.refuses([*command, "--arm", "nosuch"], 2, "nosuch")

    def test_rows_in_another_order_give_the_same_camera_and_the_same_folds(self):
        self.runs("world", "sample", "camera", "--out", "camera")
        self.runs("world", "sample", "arm", "--points", "40", "--out", "arm")
        for kind, file, options, keys in (("camera", "camera/corners.csv", ["--corners"], ["fx", "fy", "cx", "cy"]),
                                          ("arm", "arm/arm.csv", ["--arm", "phantom-premium-1.5", "--samples"], ["test_mean_mm", "test_max_mm"])):
            header, *rows = self.read(file).decode().splitlines()
            self.write("turned.csv", "\n".join([header, *rows[::-1]]) + "\n")
            this, other = (json.loads(self.runs("calibrate", kind, *options, name, "--json", "-").out) for name in (file, "turned.csv"))
            for key in keys:
                self.assertAlmostEqual(this[key], other[key], delta=1e-5 if kind == "camera" else 1e-6)

    def test_a_byte_order_mark_is_no_part_of_the_header(self):
        self.write("plain.csv", poses(TURNS))
        self.write("marked.csv", b"\xef\xbb\xbf" + poses(TURNS).encode())
        plain, marked = (json.loads(self.runs("calibrate", "pivot", "--poses", name, "--json", "-").out) for name in ("plain.csv", "marked.csv"))
        self.assertEqual(plain["tip_mm"], marked["tip_mm"])
        self.assertEqual(plain["std"], marked["std"])

    def test_a_camera_from_one_view(self):
        rows = "".join(f"one,{i},{i % 9},{i // 9},{100 + 20 * (i % 9)},{100 + 20 * (i // 9)}\n" for i in range(54))
        self.write("corners.csv", "image,corner,board_x_squares,board_y_squares,u_px,v_px\n" + rows)
        self.refuses(["calibrate", "camera", "--corners", "corners.csv", "--json", "result.json", "--out", "part.toml"], 1, "corners.csv", "view")


if __name__ == "__main__":
    unittest.main()
