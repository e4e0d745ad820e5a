#!/usr/bin/env python3
"""Tries recompute.py on folders whose errors are known in closed form, and on folders that lie."""
import contextlib
import csv
import io
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
sys.dont_write_bytecode = True
import recompute  # noqa: E402

LENS = dict(fx=500, fy=400, cx=320, cy=240, k1=0, k2=0, p1=0, p2=0, k3=0)
ARM = dict(gains=[1, 1, 1], offsets_deg=[0, 0, 0], lengths_mm=[200, 200], tip_mm=[0, 0, -100],
           base=dict(translation_mm=[0, 0, 0], rotation_qwxyz=[1, 0, 0, 0]))


def write_rows(folder, name, rows):
    with open(os.path.join(folder, "raw", name), "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


def pose(prefix, x, y, z, q=(1, 0, 0, 0)):
    values = (x, y, z, *q)
    return {prefix + n: v for n, v in zip(("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"), values)}


class Recompute(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = self.scratch.name
        os.mkdir(os.path.join(self.folder, "raw"))
        # The estimated base stands 3 mm beside the true one: every pose is 3 mm off.
        beside = {**ARM, "base": dict(translation_mm=[3, 0, 0], rotation_qwxyz=[2, 0, 0, 0])}
        self.write("raw/estimates.json", dict(arm={"joint": beside, "eq7": ARM}, pivot=dict(tip_mm=[0, 3, 4]),
                                              hand_eye=dict(translation_mm=[1, 2, 2], rotation_qwxyz=[math.cos(.01), math.sin(.01), 0, 0])))
        self.write("raw/truth.json", dict(arm=ARM, pivot=dict(tip_mm=[0, 0, 0]), hand_eye=dict(translation_mm=[0, 0, 0], rotation_qwxyz=[-1, 0, 0, 0])))
        write_rows(self.folder, "arm_poses.csv", [dict(pose=i, joint_1_deg=i, joint_2_deg=10, joint_3_deg=-5) for i in range(5)])
        # Camera estimated 2 mm to the right, points 1 m ahead: 500 px * 0.002 = 1 px. The tip is 0.5 m ahead and right in
        # the estimate but for the camera: 2 px. The second point lies outside of the image.
        write_rows(self.folder, "frames.csv", [dict(frame=7, mid_exposure_s=0.1, **pose("cam_", 0.002, 0, 0), tip_x_m=0, tip_y_m=0, tip_z_m=0.5,
                                                    answer="exact", late=0, world_px=1.0, tip_px=2.0)])
        write_rows(self.folder, "truth_frames.csv", [dict(frame=7, **pose("cam_", 0, 0, 0), tip_x_m=0, tip_y_m=0, tip_z_m=0.5)])
        write_rows(self.folder, "check_points.csv", [dict(point=i, true_x_m=x, true_y_m=0, true_z_m=1, est_x_m=x, est_y_m=0, est_z_m=1) for i, x in enumerate((0.1, 2.0))])
        write_rows(self.folder, "lens.csv", [dict(which="est", **LENS), dict(which="true", **LENS)])
        write_rows(self.folder, "haptics.csv", [dict(time_s=0, given_n=-4.5), dict(time_s=0.001, given_n=2)])
        # The real-time run: 4 mm to the right, joined by the camera's count; the first picture comes before it has settled.
        shown = dict(**pose("cam_", 0.004, 0, 0), tip_x_m=0, tip_y_m=0, tip_z_m=0.5)
        write_rows(self.folder, "realtime_poses.csv", [dict(frame=1, camera_frame=40, time_s=0.5, late=0, world_px="", tip_px="", **{**shown, "cam_x_m": 0.1}),
                                                       dict(frame=2, camera_frame=42, time_s=1.5, late=0, world_px=2.0, tip_px=4.0, **shown)])
        write_rows(self.folder, "realtime_truth.csv", [dict(frame=f, **pose("cam_", 0, 0, 0), tip_x_m=0, tip_y_m=0, tip_z_m=0.5) for f in (40, 41, 42)])
        self.summary = dict(arm=dict(error_to_truth_mean_mm=3.0, eq7_error_to_truth_mm=0.0), pivot=dict(error_to_truth_mm=5.0), hand_eye=dict(error_to_truth_mm=3.0, rotation_error_deg=math.degrees(0.02)),
                            registration=dict(world_px_rms=1.0, world_px_p95=1.0, tip_px_rms=2.0, tip_px_p95=2.0),
                            exchange=dict(frames=1, late=0, answers=dict(exact=1, interpolated=0, extrapolated=0, too_old=0)), force=dict(peak_n=4.5),
                            realtime=dict(overlay=dict(warm_up_s=1.0, world_px_rms=2.0, world_px_p95=2.0, tip_px_rms=4.0, tip_px_p95=4.0, tip_px_rms_in_time=4.0)))

    def tearDown(self):
        self.scratch.cleanup()

    def write(self, name, value):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            json.dump(value, file)

    def recompute(self):
        self.write("summary.json", self.summary)
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            code = recompute.main([self.folder])
        return code, said.getvalue()

    def test_agrees_with_errors_known_in_closed_form(self):
        code, text = self.recompute()
        self.assertEqual(code, 0, text)
        self.assertIn("agrees   registration/tip_px_rms: 2", text)

    def test_each_figure_that_lies_is_named(self):
        for path in ("arm/error_to_truth_mean_mm", "pivot/error_to_truth_mm", "hand_eye/error_to_truth_mm", "hand_eye/rotation_error_deg", "registration/world_px_rms",
                     "registration/tip_px_p95", "exchange/late", "exchange/answers/exact", "force/peak_n", "realtime/overlay/world_px_rms", "realtime/overlay/tip_px_rms_in_time"):
            self.tearDown()
            self.setUp()
            part = self.summary
            *folders, key = path.split("/")
            for name in folders:
                part = part[name]
            part[key] += 1e-4
            code, text = self.recompute()
            self.assertEqual(code, 1, path)
            self.assertIn("DIFFERS  " + path, text)
            self.assertEqual(text.count("DIFFERS"), 1, text)

    def test_a_frame_that_lies_is_named(self):
        write_rows(self.folder, "frames.csv", [dict(frame=7, mid_exposure_s=0.1, **pose("cam_", 0.002, 0, 0), tip_x_m=0, tip_y_m=0, tip_z_m=0.5,
                                                    answer="exact", late=0, world_px=0.9, tip_px=2.0)])
        code, text = self.recompute()
        self.assertEqual(code, 1)
        self.assertIn("frame 7 world_px: recomputed 1, stated 0.9", text)

    def test_a_figure_without_its_raw_files_is_not_taken_on_trust(self):
        os.remove(os.path.join(self.folder, "raw", "check_points.csv"))
        code, text = self.recompute()
        self.assertEqual(code, 1)
        self.assertIn("registration/world_px_rms: stated, but the raw files", text)

    def test_no_summary_is_wrong_use(self):
        done = subprocess.run([sys.executable, os.path.join(HERE, "recompute.py"), self.folder], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)

    def test_unbending_undoes_the_lens(self):
        lens = recompute.Lens(dict(LENS, k1=-0.28, k2=0.09, p1=0.001, p2=-0.0005, k3=0.01))
        for x, y in ((0, 0), (0.5, 0.3), (-0.57, 0.42), (0.2, -0.43)):
            u, v = lens.unbend(*lens.bend(x, y))
            self.assertAlmostEqual(u, x, places=12)
            self.assertAlmostEqual(v, y, places=12)

    def test_the_arm_at_reset_is_at_its_base_and_turns_about_the_vertical(self):
        self.assertEqual(recompute.arm_tip(ARM, [0, 0, 0]), [0, 0, 0])
        x, y, z = recompute.arm_tip(ARM, [90, 0, 0])  # the forearm hangs at 200 mm from the axis, 200 mm behind the origin
        self.assertAlmostEqual(x, 200)
        self.assertAlmostEqual(y, 0)
        self.assertAlmostEqual(z, -200)

    def test_the_stylus_turns_with_arm_and_gimbal(self):
        arm = {"gains": [1, 1, 1], "offsets_deg": [0, 0, 0], "base": {"rotation_qwxyz": [1, 0, 0, 0]}}
        gimbal = {"gimbal_gains": [1, 2, 1], "gimbal_offsets_deg": [10, 0, 0]}
        # 30 from the first joint, 20 + 10 from the gimbal's first, all about y
        about_y = recompute.stylus(arm, gimbal, [30, 0, 0], [20, 0, 0])
        self.assertAlmostEqual(recompute.turn_between_deg(about_y, recompute.turn(1, math.radians(60))), 0, places=9)
        # the third joint bends the forearm down as the gimbal's second, at gain 2, bends the stylus up
        flat = recompute.stylus(arm, dict(gimbal, gimbal_offsets_deg=[0, 0, 0]), [0, 0, 40], [0, 20, 0])
        self.assertAlmostEqual(recompute.turn_between_deg(flat, [1, 0, 0, 0]), 0, places=9)


if __name__ == "__main__":
    unittest.main()
