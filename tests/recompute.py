#!/usr/bin/env python3
"""Recomputes a demo's errors from its raw files and compares them with summary.json.

    recompute.py FOLDER [--palpate PROGRAM [--world FILE]] [--tolerance 1e-6]

Standard library only, and no code shared with the program: kinematics, rotations and lens are written here again.
Prints a line per figure; exit 1 with a line per difference where one exceeds the tolerance (relative), 2 for wrong use.

What it reads in FOLDER (a figure whose files are missing is not recomputed, and said so):
  summary.json
  raw/estimates.json     {"arm": {"joint": R, "one-pass": R, "alternating": R, "eq7": R}, "pivot": R, "hand_eye": R}, each R the
                         result of the matching `calibrate --json`
  raw/truth.json         {"arm": T, "pivot": T, "hand_eye": T}, each T the truth.json of the matching `world sample`.
                         With --palpate these come from the program instead, for the world (else FOLDER/world.toml) and
                         the summary's seed.
  raw/arm_poses.csv      pose,joint_1_deg,joint_2_deg,joint_3_deg: readings at which the arm is held against the truth
  raw/arm_held_out.csv   arm samples not used for the calibration: joint_1_deg..,marker_x_mm..,marker_qw..
  raw/frames.csv         frame,mid_exposure_s,cam_x_m..cam_qz,tip_x_m,tip_y_m,tip_z_m,answer,late,world_px,tip_px  (estimates;
                         optional tracker_cam_x_m..tracker_cam_qz: the pose before the picture refined it)
  raw/truth_frames.csv   frame,cam_x_m..cam_qz,tip_x_m,tip_y_m,tip_z_m
  raw/check_points.csv   point,true_x_m,true_y_m,true_z_m,est_x_m,est_y_m,est_z_m
  raw/lens.csv           which(est|true),fx,fy,cx,cy,k1,k2,p1,p2,k3[,width,height,lens]
  raw/frames_right.csv, truth_frames_right.csv, lens_right.csv: the same of the right eye, where a demo had two
  raw/haptics.csv        given_n        raw/realtime_frames.csv   round_trip_us
  raw/realtime_poses.csv as frames.csv, with camera_frame and time_s; raw/realtime_truth.csv as truth_frames.csv, its frame the
                         camera's

The overlay error of a point: its virtual twin is drawn with the estimated pose and the estimated focal lengths and centre;
the real point goes through the true camera and the true lens into the image, and from there through the estimated lens into
the drawn, undistorted picture. Points outside of the image are left out.
"""
import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

NEAREST_M = 0.02  # closer in front of a camera nothing has a pixel


# --- vectors and rotations -----------------------------------------------------------------------------------------

def rotate(q, v):
    """v turned by the quaternion q = (w, x, y, z), which need not have unit length."""
    n = math.sqrt(sum(c * c for c in q))
    w, u = q[0] / n, [c / n for c in q[1:]]
    t = [2 * c for c in cross(u, v)]
    s = cross(u, t)
    return [v[k] + w * t[k] + s[k] for k in range(3)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def into(pose, point):
    """A point of the outer frame in the frame of pose = (place, quaternion)."""
    place, (w, x, y, z) = pose
    return rotate((w, -x, -y, -z), [a - b for a, b in zip(point, place)])


def turn_between_deg(p, q):
    p, q = ([c / math.sqrt(sum(d * d for d in a)) for c in a] for a in (p, q))
    return math.degrees(4 * math.asin(min(1.0, min(math.dist(p, q), math.dist(p, [-c for c in q])) / 2)))


# --- models --------------------------------------------------------------------------------------------------------

def arm_tip(model, readings_deg):
    """Tip in World, mm: joint correction, the arm's kinematics (Cavusoglu and others 2002), place of the base."""
    a, b, c = (g * math.radians(r) + math.radians(o)
               for g, r, o in zip(model["gains"], readings_deg, model["offsets_deg"]))
    l1, l2 = model["lengths_mm"]
    reach = l1 * math.cos(b) + l2 * math.sin(c)
    tip = [math.sin(a) * reach, l2 - l2 * math.cos(c) + l1 * math.sin(b), math.cos(a) * reach - l1]
    base = model["base"]
    return [u + v for u, v in zip(rotate(base["rotation_qwxyz"], tip), base["translation_mm"])]


def product(*quaternions):
    w, u = 1.0, [0.0, 0.0, 0.0]
    for q in quaternions:
        t = q[1:]
        w, u = w * q[0] - sum(a * b for a, b in zip(u, t)), [w * b + q[0] * a + c for a, b, c in zip(u, t, cross(u, t))]
    return [w, *u]


def turn(axis, angle):
    return [math.cos(angle / 2), *(math.sin(angle / 2) if k == axis else 0.0 for k in range(3))]


def stylus(arm, gimbal, joints_deg, gimbal_deg):
    """Orientation of the stylus in World: base Ry(t1) Rx(-t3) Ry(t4) Rx(t5) Rz(t6)."""
    t1, _, t3 = (g * math.radians(r) + math.radians(o) for g, r, o in zip(arm["gains"], joints_deg, arm["offsets_deg"]))
    t4, t5, t6 = (g * math.radians(r) + math.radians(o)
                  for g, r, o in zip(gimbal["gimbal_gains"], gimbal_deg, gimbal["gimbal_offsets_deg"]))
    return product(arm["base"]["rotation_qwxyz"], turn(1, t1), turn(0, -t3), turn(1, t4), turn(0, t5), turn(2, t6))


class Lens:
    def __init__(self, row):
        self.fx, self.fy, self.cx, self.cy, self.k1, self.k2, self.p1, self.p2, self.k3 = (
            float(row[k]) for k in ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"))
        self.width, self.height = float(row.get("width") or 640), float(row.get("height") or 480)
        self.fisheye = row.get("lens") == "fisheye"  # then the five are k1 k2 k3 k4 0
        self.k4, self.k5, self.k6 = (float(row.get(k) or 0) for k in ("k4", "k5", "k6"))

    def bend(self, x, y):
        if self.fisheye:
            r = math.hypot(x, y)
            t = math.atan(r)
            seen = t + self.k1 * t ** 3 + self.k2 * t ** 5 + self.p1 * t ** 7 + self.p2 * t ** 9
            return (x * seen / r, y * seen / r) if r else (x, y)
        r2 = x * x + y * y
        f = (1 + self.k1 * r2 + self.k2 * r2 ** 2 + self.k3 * r2 ** 3) / (1 + self.k4 * r2 + self.k5 * r2 ** 2 + self.k6 * r2 ** 3)
        return (x * f + 2 * self.p1 * x * y + self.p2 * (r2 + 2 * x * x),
                y * f + self.p1 * (r2 + 2 * y * y) + 2 * self.p2 * x * y)

    def unbend(self, x, y):
        """Newton's method with a Jacobian by central differences; None where it does not settle."""
        if self.fisheye:  # by halves: the angle grows with the distance from the axis
            distance, low, high = math.hypot(x, y), 0.0, math.radians(80)
            if not distance:
                return x, y
            if math.hypot(*self.bend(math.tan(high), 0.0)) < distance:
                return None
            while high - low > 1e-15:
                angle = (low + high) / 2
                if not low < angle < high:
                    break
                low, high = (low, angle) if self.bend(math.tan(angle), 0.0)[0] > distance else (angle, high)
            return x * math.tan(low) / distance, y * math.tan(low) / distance
        u, v, h = x, y, 1e-6
        for _ in range(60):
            bx, by = self.bend(u, v)
            if math.hypot(bx - x, by - y) < 1e-14:
                return u, v
            (ax, ay), (cx, cy) = self.bend(u + h, v), self.bend(u - h, v)
            (dx, dy), (ex, ey) = self.bend(u, v + h), self.bend(u, v - h)
            j11, j21, j12, j22 = (ax - cx) / (2 * h), (ay - cy) / (2 * h), (dx - ex) / (2 * h), (dy - ey) / (2 * h)
            det = j11 * j22 - j12 * j21
            if abs(det) < 1e-9:
                return None
            u -= ((bx - x) * j22 - (by - y) * j12) / det
            v -= ((by - y) * j11 - (bx - x) * j21) / det
            if math.hypot(u, v) > 10:
                return None
        return (u, v) if math.hypot(bx - x, by - y) < 1e-10 else None

    def flat(self, p):
        return self.fx * p[0] / p[2] + self.cx, self.fy * p[1] / p[2] + self.cy

    def real(self, p):
        x, y = self.bend(p[0] / p[2], p[1] / p[2])
        return self.fx * x + self.cx, self.fy * y + self.cy

    def flattened(self, pixel):
        n = self.unbend((pixel[0] - self.cx) / self.fx, (pixel[1] - self.cy) / self.fy)
        return None if n is None else (self.fx * n[0] + self.cx, self.fy * n[1] + self.cy)


def offset_px(est_pose, est_lens, est_point, true_pose, true_lens, true_point):
    """From where the real point is seen to where its virtual twin is drawn, u and v."""
    seen, drawn = into(true_pose, true_point), into(est_pose, est_point)
    if seen[2] < NEAREST_M or drawn[2] < NEAREST_M:
        return None
    w, h = true_lens.width, true_lens.height
    u, v = true_lens.flat(seen)
    if not (-w / 2 <= u <= 1.5 * w and -h / 2 <= v <= 1.5 * h):  # the lens polynomial folds back far outside
        return None
    u, v = true_lens.real(seen)
    if not (0 <= u <= w - 1 and 0 <= v <= h - 1):
        return None
    real = est_lens.flattened((u, v))
    if real is None:
        return None
    u, v = est_lens.flat(drawn)
    return u - real[0], v - real[1]


def overlay_px(*poses_lenses_points):
    offset = offset_px(*poses_lenses_points)
    return None if offset is None else math.hypot(*offset)


# --- files and comparison ------------------------------------------------------------------------------------------

class Demo:
    def __init__(self, folder, program, world):
        self.folder = folder
        self.summary = self.json("summary.json") or {}
        self.estimates = self.json("raw/estimates.json") or {}
        self.truth = self.from_program(program, world or os.path.join(folder, "world.toml")) if program else self.json("raw/truth.json") or {}

    def json(self, name):
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            return None
        with open(path, encoding="utf-8") as file:
            return json.load(file)

    def rows(self, name):
        path = os.path.join(self.folder, "raw", name)
        if not os.path.exists(path):
            return []
        with open(path, encoding="utf-8", newline="") as file:
            return list(csv.DictReader(line for line in file if line.strip() and not line.startswith("#")))

    def from_program(self, program, world):
        truth = {}
        for kind, key in (("arm", "arm"), ("pivot", "pivot"), ("hand-eye", "hand_eye")):
            with tempfile.TemporaryDirectory() as out:
                subprocess.run([program, "world", "sample", kind, "--world", world, "--seed",
                                str(self.summary["seed"]), "--out", out], check=True, stdout=subprocess.DEVNULL)
                with open(os.path.join(out, "truth.json"), encoding="utf-8") as file:
                    truth[key] = json.load(file)
        return truth

    def stated(self, path):
        value = self.summary
        for key in path.split("/"):
            value = value.get(key) if isinstance(value, dict) else None
        return value


def numbers(row, *names):
    return [float(row[n]) for n in names]


def pose_of(row, prefix="cam_"):
    return numbers(row, prefix + "x_m", prefix + "y_m", prefix + "z_m"), numbers(row, *(prefix + q for q in ("qw", "qx", "qy", "qz")))


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def nearest_rank(values, share):
    ordered = sorted(values)
    return ordered[max(1, min(len(ordered), math.ceil(share * len(ordered)))) - 1]


def arm_figures(demo):
    truth, methods, poses = demo.truth.get("arm"), demo.estimates.get("arm", {}), demo.rows("arm_poses.csv")
    keys = {"joint": "error_to_truth_mean_mm", "one-pass": "one_pass_error_to_truth_mm",
            "alternating": "alternating_error_to_truth_mm", "eq7": "eq7_error_to_truth_mm"}
    if truth and poses:
        readings = [numbers(p, "joint_1_deg", "joint_2_deg", "joint_3_deg") for p in poses]
        places = [arm_tip(truth, r) for r in readings]
        for method, model in methods.items():
            model = {"lengths_mm": truth["lengths_mm"], **model}
            yield "arm/" + keys.get(method, method), sum(math.dist(arm_tip(model, r), p) for r, p in zip(readings, places)) / len(places)
    held_out, joint = demo.rows("arm_held_out.csv"), methods.get("joint")
    if held_out and joint and "lengths_mm" in joint:
        total = 0.0
        for s in held_out:
            marker = numbers(s, "marker_x_mm", "marker_y_mm", "marker_z_mm")
            turned = rotate(numbers(s, "marker_qw", "marker_qx", "marker_qy", "marker_qz"), joint["tip_mm"])
            tip = arm_tip(joint, numbers(s, "joint_1_deg", "joint_2_deg", "joint_3_deg"))
            total += math.dist(tip, [a + b for a, b in zip(marker, turned)])
        yield "arm/heldout_mean_mm", total / len(held_out)
    if held_out and joint and truth and "gimbal" in demo.estimates:
        readings = [(numbers(s, "joint_1_deg", "joint_2_deg", "joint_3_deg"), numbers(s, "gimbal_1_deg", "gimbal_2_deg", "gimbal_3_deg"))
                    for s in held_out]
        turns = [turn_between_deg(stylus(joint, demo.estimates["gimbal"], *r), stylus(truth, truth, *r)) for r in readings]
        yield "arm/stylus_error_to_truth_deg", sum(turns) / len(turns)


def offset_figures(demo):
    for part, key in (("pivot", "tip_mm"), ("hand_eye", "translation_mm")):
        estimate, truth = demo.estimates.get(part), demo.truth.get(part)
        if estimate and truth:
            yield part + "/error_to_truth_mm", math.dist(estimate[key], truth[key])
            if "rotation_qwxyz" in estimate and "rotation_qwxyz" in truth:
                yield part + "/rotation_error_deg", turn_between_deg(estimate["rotation_qwxyz"], truth["rotation_qwxyz"])


def overlay_figures(demo, differ):
    """Of the lock-step play, each eye's, and of the real-time leg, whose two files are joined by the camera's count of images."""
    for eye, ending in (("", ""), ("right_eye/", "_right")):
        yield from overlay_of(demo, differ, "registration/" + eye, f"frames{ending}.csv", f"truth_frames{ending}.csv", "frame", lambda row: True, ending)
    settled = demo.stated("realtime/overlay/warm_up_s") or 0.0
    yield from overlay_of(demo, differ, "realtime/overlay/", "realtime_poses.csv", "realtime_truth.csv", "camera_frame",
                          lambda row: float(row["time_s"]) >= settled)


def overlay_of(demo, differ, part, drawn, true, key, counts, ending=""):
    frames = demo.rows(drawn)
    truth = {row["frame"]: row for row in demo.rows(true)}
    points = demo.rows("check_points.csv")
    lenses = {row["which"]: Lens(row) for row in demo.rows(f"lens{ending}.csv")}
    if not (frames and truth and points and {"est", "true"} <= set(lenses)):
        return
    est_lens, true_lens = lenses["est"], lenses["true"]
    twins = [(numbers(p, "est_x_m", "est_y_m", "est_z_m"), numbers(p, "true_x_m", "true_y_m", "true_z_m")) for p in points]
    world, only, tips, in_time = [], [], [], []
    for row in frames:
        if row[key] not in truth:
            differ(f"raw/{drawn}: frame {row['frame']} has no row in raw/{true}")
            continue
        if not counts(row):
            continue
        true_row = truth[row[key]]
        true_pose = pose_of(true_row)
        for prefix, errors in (("cam_", world), ("tracker_cam_", only)):
            if not row.get(prefix + "x_m"):
                continue
            pose = pose_of(row, prefix)
            found = [e for est, true in twins if (e := overlay_px(pose, est_lens, est, true_pose, true_lens, true)) is not None]
            errors += found
            if prefix == "cam_" and row.get("world_px") and found:
                differ.compare(f"raw/{drawn} frame {row['frame']} world_px", rms(found), float(row["world_px"]), quiet=True)
        if row.get("tip_x_m") and true_row.get("tip_x_m") and row.get("cam_x_m"):
            error = overlay_px(pose_of(row), est_lens, numbers(row, "tip_x_m", "tip_y_m", "tip_z_m"), true_pose, true_lens,
                               numbers(true_row, "tip_x_m", "tip_y_m", "tip_z_m"))
            if error is not None:
                tips.append(error)
                if row.get("late") == "0":
                    in_time.append(error)
                if row.get("tip_px"):
                    differ.compare(f"raw/{drawn} frame {row['frame']} tip_px", error, float(row["tip_px"]), quiet=True)
    if world:
        yield part + "world_px_rms", rms(world)
        yield part + "world_px_p95", nearest_rank(world, 0.95)
    if only:
        yield part + "world_px_rms_tracker_only", rms(only)
    if tips:
        yield part + "tip_px_rms", rms(tips)
        yield part + "tip_px_p95", nearest_rank(tips, 0.95)
    if in_time and part.startswith("realtime"):
        yield part + "tip_px_rms_in_time", rms(in_time)


def disparity_figures(demo):
    """Places of virtual points in the left picture less those in the right one, beside those of real points."""
    eyes = []
    for ending in ("", "_right"):
        frames = {row["frame"]: row for row in demo.rows(f"frames{ending}.csv")}
        truth = {row["frame"]: row for row in demo.rows(f"truth_frames{ending}.csv")}
        lenses = {row["which"]: Lens(row) for row in demo.rows(f"lens{ending}.csv")}
        if not (frames and truth and {"est", "true"} <= set(lenses)):
            return
        eyes.append((frames, truth, lenses["est"], lenses["true"]))
    twins = [(numbers(p, "est_x_m", "est_y_m", "est_z_m"), numbers(p, "true_x_m", "true_y_m", "true_z_m"))
             for p in demo.rows("check_points.csv")]
    errors = []
    for frame in eyes[1][0]:
        if frame not in eyes[0][0]:
            continue
        for est, true in twins:
            offsets = [offset_px(pose_of(frames[frame]), est_lens, est, pose_of(truth[frame]), true_lens, true)
                       for frames, truth, est_lens, true_lens in eyes]
            if None not in offsets:
                errors.append(math.dist(*offsets))
    if errors:
        yield "registration/disparity/world_px_rms", rms(errors)
        yield "registration/disparity/world_px_p95", nearest_rank(errors, 0.95)


def count_figures(demo):
    frames = demo.rows("frames.csv")
    if frames and "answer" in frames[0]:
        yield "exchange/frames", len(frames)
        yield "exchange/late", sum(int(float(f["late"])) for f in frames)
        for kind in ("exact", "interpolated", "extrapolated", "too_old"):
            yield "exchange/answers/" + kind, sum(f["answer"] == kind for f in frames)
    haptics = demo.rows("haptics.csv")
    if haptics:
        yield "force/peak_n", max(abs(float(h["given_n"])) for h in haptics)


class Differences:
    def __init__(self, tolerance):
        self.tolerance, self.count, self.compared = tolerance, 0, 0

    def __call__(self, message):
        self.count += 1
        print("DIFFERS  " + message)

    def compare(self, name, recomputed, stated, quiet=False):
        self.compared += 1
        # An error of a millionth of a pixel or millimetre is rounding, however small the figure itself is.
        if not isinstance(stated, (int, float)):
            self(f"{name}: recomputed {recomputed:.9g}, not stated")
        elif not abs(recomputed - stated) <= self.tolerance * max(abs(recomputed), abs(stated)) + 1e-9:
            self(f"{name}: recomputed {recomputed:.9g}, stated {stated:.9g}")
        elif not quiet:
            print(f"agrees   {name}: {recomputed:.9g}")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("--palpate", metavar="PROGRAM", help="take the truth from `PROGRAM world sample` instead of raw/truth.json")
    parser.add_argument("--world", metavar="FILE", help="the world of the demo; with --palpate")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="relative; default 1e-6")
    options = parser.parse_args(arguments)
    if not os.path.isfile(os.path.join(options.folder, "summary.json")):
        print(f"recompute.py: {options.folder}: no summary.json; give the folder a demo wrote", file=sys.stderr)
        return 2
    demo = Demo(options.folder, options.palpate, options.world)
    differ = Differences(options.tolerance)
    done = set()
    for figures in (arm_figures(demo), offset_figures(demo), overlay_figures(demo, differ), disparity_figures(demo), count_figures(demo)):
        for name, value in figures:
            stated = demo.stated(name)
            if stated is None and name.endswith("rotation_error_deg"):
                continue  # welcome, not promised
            differ.compare(name, value, stated)
            done.add(name)
    promised = ["arm/error_to_truth_mean_mm", "arm/one_pass_error_to_truth_mm", "arm/alternating_error_to_truth_mm", "arm/eq7_error_to_truth_mm",
                "arm/heldout_mean_mm", "pivot/error_to_truth_mm", "hand_eye/error_to_truth_mm", "registration/world_px_rms",
                "registration/tip_px_rms", "exchange/frames", "force/peak_n"]
    for name in promised:
        if demo.stated(name) is not None and name not in done:
            differ(f"{name}: stated, but the raw files to recompute it are missing")
    print(f"{differ.compared} compared, {differ.count} differ")
    return 1 if differ.count else 0


if __name__ == "__main__":
    sys.exit(main())
