#!/usr/bin/env python3
"""Tables of numbers that are missing, malformed or hold what is no number, given to every command that reads one."""
import json
import os
import unittest

from program import ProgramTest

FLIGHTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "flights")
POSES = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
POINTS = "x_mm,y_mm,z_mm\n"
# Option under test: file name, command (FILE stands for the bad one), header, a good row.
TABLES = {
    "pivot --poses": (["calibrate", "pivot", "--poses", "FILE"], POSES, "0,1,2,3,1,0,0,0\n"),
    "points --from": (["calibrate", "points", "--from", "FILE", "--to", "points.csv"], POINTS, "1,2,3\n"),
    "points --to": (["calibrate", "points", "--from", "points.csv", "--to", "FILE"], POINTS, "1,2,3\n"),
    "surface --points": (["calibrate", "surface", "--points", "FILE"], POINTS, "1,2,3\n"),
    "arm --samples": (["calibrate", "arm", "--arm", "phantom-premium-1.5", "--samples", "FILE"],
                      "joint_1_deg,joint_2_deg,joint_3_deg,x_mm,y_mm,z_mm\n", "1,2,3,4,5,6\n"),
    "camera --corners": (["calibrate", "camera", "--corners", "FILE"],
                         "image,corner,board_x_squares,board_y_squares,u_px,v_px\n", "one,0,0,0,100,100\n"),
    "hand-eye --hand": (["calibrate", "hand-eye", "--hand", "FILE", "--eye", "poses.csv"], POSES, "0,1,2,3,1,0,0,0\n"),
    "hand-eye --eye": (["calibrate", "hand-eye", "--hand", "poses.csv", "--eye", "FILE"], POSES, "0,1,2,3,1,0,0,0\n"),
    "delay --from": (["calibrate", "delay", "--from", "FILE", "--to", "poses.csv"], POSES, "0,1,2,3,1,0,0,0\n"),
    "delay --to": (["calibrate", "delay", "--from", "poses.csv", "--to", "FILE"], "time_s," + POINTS, "0,1,2,3\n"),
}


# What other programs write, and what is said of it.
FOREIGN = {
    "tabs": ("time_s\tx_mm\n0\t1\n", "is separated by tabs"),
    "semicolons": ("time_s;x_mm\n0;1\n", "is separated by semicolons"),
    "decimal commas": ("time_s;x_mm\n0,5;1\n", "has decimal commas"),
    "json": ('[{"x": 1}]\n', "is JSON"),
    "nrrd": ("NRRD0004\ntype: unsigned char\n", "is an NRRD file"),
    "fcsv": ("# Markups fiducial file version = 4.11\nF_1,1,2,north,0,0,0,1,1,1,0,F-1,,\n", "markups of 3D Slicer (.fcsv)"),
    "itk": ("#Insight Transform File V1.0\n#Transform 0\nParameters: 1 0 0\n", "is a transform of ITK"),
    "ndi": ("Tools,Port 1: 8700340,Frame,State,Q0\n1,,17,OK,1\n", "is an export of NDI's programs"),
    "rig": ("rig_version = 1\n", "is a rig file"),
}


class BadTables(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("poses.csv", POSES + "0,1,2,3,1,0,0,0\n")
        self.write("points.csv", POINTS + "1,2,3\n")

    def refuses_in_all(self, content, *words, only=TABLES):
        """`content` makes the file from its header and a good row; `only` where all tables go the same way."""
        for option in only:
            with self.subTest(option):
                command, header, row = TABLES[option]
                if content is not None:
                    self.write("bad.csv", content(header, row))
                bad = [self.path("bad.csv") if word == "FILE" else word for word in command]
                self.refuses([*bad, "--json", "result.json"], 2, "bad.csv", *words)

    def test_a_missing_file_is_named(self):
        self.refuses_in_all(None, "no such file; check the path")

    def test_an_empty_file_is_named(self):
        self.refuses_in_all(lambda header, row: "", "is empty", only=["pivot --poses", "camera --corners"])

    def test_a_header_without_rows_is_not_enough(self):
        self.refuses_in_all(lambda header, row: header,
                            only=["pivot --poses", "points --from", "arm --samples", "camera --corners"])

    def test_bytes_are_not_a_table(self):
        self.refuses_in_all(lambda header, row: bytes(range(256)), "not a text file", only=["pivot --poses"])

    def test_nan_is_named_with_its_line_and_column(self):
        self.refuses_in_all(lambda header, row: header + row + row.rsplit(",", 1)[0] + ",nan\n",
                            "bad.csv:3: ", "is 'nan'", "finite numbers are expected")

    def test_infinity_is_no_number_either(self):
        self.refuses_in_all(lambda header, row: header + row + row.rsplit(",", 1)[0] + ",-inf\n", "bad.csv:3: ", "'-inf'",
                            only=["arm --samples"])

    def test_a_word_among_numbers_is_named_with_its_line(self):
        self.refuses_in_all(lambda header, row: header + row + row.rsplit(",", 1)[0] + ",three\n",
                            "bad.csv:3: ", "is 'three', a number is expected", only=["points --to", "arm --samples"])

    def test_options_of_the_other_way_are_not_passed_over(self):
        for option in (["--board", "9x6"], ["--square-mm", "25"], ["--stamps", "s.csv"], ["--lens", "lens.json"], ["--tracker-sd-mm", "1"]):
            self.refuses(["calibrate", "hand-eye", "--hand", "poses.csv", "--eye", "poses.csv", *option], 2,
                         f"{option[0]}: goes with --images or --corners, not with --eye")
        self.refuses(["replay", "s.mcap", "--mesh", "m.stl"], 2, "--mesh: goes with --verify")

    def test_a_result_replaces_no_table(self):
        self.write("mine.csv", POSES + "0,1,2,3,1,0,0,0\n")
        self.runs("world", "sample", "pivot", "--points", "30", "--out", "sim")
        self.refuses(["calibrate", "pivot", "--poses", "sim/pivot.csv", "--json", "mine.csv"], 2, "mine.csv: exists already and holds no JSON")
        self.runs("calibrate", "pivot", "--poses", "sim/pivot.csv", "--json", "result.json")
        self.runs("calibrate", "pivot", "--poses", "sim/pivot.csv", "--json", "result.json")
        os.mkdir(self.path("own"))
        self.write("own/pivot.csv", "mine")
        self.refuses(["world", "sample", "pivot", "--points", "30", "--out", "own"], 2, "own/pivot.csv: exists already and is of no earlier sample")
        self.assertEqual(self.read("own/pivot.csv"), b"mine")
        self.runs("world", "sample", "pivot", "--points", "30", "--out", "sim", "--seed", "2")

    def test_a_row_cut_short_is_named_with_its_line(self):
        self.refuses_in_all(lambda header, row: header + row + row + row.rsplit(",", 1)[0] + "\n", "bad.csv:4: ", "cells",
                            only=["surface --points", "hand-eye --eye"])

    def test_a_column_that_is_needed_is_named(self):
        self.refuses_in_all(lambda header, row: "a,b,c\n1,2,3\n", "a,b,c", only=["points --from", "arm --samples", "camera --corners"])

    def test_a_quaternion_of_no_length_is_no_rotation(self):
        self.write("bad.csv", POSES + "0,1,2,3,1,0,0,0\n1,1,2,3,0,0,0,0\n")
        self.refuses(["calibrate", "pivot", "--poses", "bad.csv"], 2, "bad.csv:3: ", "quaternion")

    def test_files_of_other_programs_are_named(self):
        for kind, (content, words) in FOREIGN.items():
            with self.subTest(kind):
                self.refuses_in_all(lambda header, row: content, "bad.csv:", words, only=["pivot --poses", "points --from"])
        self.refuses_in_all(lambda header, row: FOREIGN["semicolons"][0], "is separated by semicolons")

    def test_a_column_nobody_asks_for_may_hold_text(self):
        named = "".join(f"{line},{'frame_id' if at == 0 else 'world'}\n" for at, line in enumerate(("x_mm,y_mm,z_mm", "0,0,0", "9,0,0", "0,9,1")))
        self.write("named.csv", named)
        self.runs("calibrate", "points", "--from", "named.csv", "--to", "named.csv")

    def test_points_without_a_partner_of_their_label_are_told_of(self):
        def points(name, labels):
            self.write(name, "x_mm,y_mm,z_mm,label\n" + "".join(f"{row},{label}\n" for row, label in zip(("0,0,0", "90,0,0", "0,90,10", "0,0,90"), labels)))
        points("four.csv", "abcd")
        points("three.csv", "abc")
        points("others.csv", "wxyz")
        done = self.runs("calibrate", "points", "--from", "four.csv", "--to", "three.csv")
        self.assertIn("1 of 4 points have no partner", done.out + done.err)
        self.assertNotIn("no partner", self.runs("calibrate", "points", "--from", "four.csv", "--to", "four.csv").out)
        self.refuses(["calibrate", "points", "--from", "four.csv", "--to", "others.csv"], 2, "no label in common", "the same labels are expected")

    def test_a_table_is_no_rig(self):
        self.refuses(["rig", "check", "poses.csv"], 2, "poses.csv: is a table of cells with commas; a rig file is expected")

    def test_a_folder_of_tables_is_no_folder_of_matrices(self):
        os.mkdir(self.path("pivot"))
        self.write("pivot/pivot.csv", POSES + "0,1,2,3,1,0,0,0\n")
        self.refuses(["calibrate", "pivot", "--poses", "pivot"], 2, "pivot: holds a table, pivot.csv", "name the table")

    def test_standard_input_is_not_read(self):
        for command in (["calibrate", "pivot", "--poses", "-"], ["calibrate", "points", "--from", "points.csv", "--to", "-"],
                        ["calibrate", "pivot", "--poses", "poses.csv", "--rig", "-"], ["rig", "check", "-"],
                        ["recording", "info", "-"]):
            self.refuses(command, 2, "-: standard input is not read; name a file")

    def test_one_bad_flight_in_a_folder_is_named(self):
        os.mkdir(self.path("flights"))
        study = ["study", "flights", "--data", "flights", "--out", "figures", "--json", "result.json"]
        self.refuses(study, 2, "flights", "*.csv")
        self.write("flights/one.csv", "t_s,x_m,y_m,z_m\n0,0,0,1\n0.1,0,nan,1\n")
        self.refuses(study, 2, "one.csv:3: ", "nan")
        self.refuses(["study", "flights", "--data", "nowhere"], 2, "nowhere")

    def test_standard_output_is_the_figures_alone_where_they_go_there(self):
        for study in (["study", "points", "--runs", "1"], ["study", "flights", "--data", FLIGHTS]):
            asked = self.runs(*study, "--json", "-")
            json.loads(asked.out)
            self.assertNotEqual(asked.err, "", "the lines for a person")
            self.assertEqual(self.runs(*study).out, asked.err)

    def test_images_that_are_none_are_named(self):
        self.refuses(["calibrate", "camera", "--images", "left*.jpg"], 2, "left*.jpg")
        self.write("left1.jpg", bytes(range(256)))
        self.refuses(["calibrate", "camera", "--images", "left*.jpg"], 2, "left1.jpg", "not an image")


if __name__ == "__main__":
    unittest.main()
