"""A rig calibrated in a laboratory, and a game played with it, beside what was true: tests/recompute.py's figures of a folder made for it."""
import csv
import json
import os
import random
import sys
import tomllib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import recompute  # noqa: E402

POSE = [f"cam_{n}" for n in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
JUDGED_POSES = 500  # of the arm, over the whole of its range
WARM_UP_S = 1.0  # clocks settle and the person takes the stylus, as in the demo's real-time run


def write_rows(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def lens_row(which, lens):
    return {"which": which, **{k: lens[k] for k in ("fx", "fy", "cx", "cy")}, **dict(zip(("k1", "k2", "p1", "p2", "k3"), lens["distortion"]))}


def check_points(rig, world):
    """A grid on table and wall: where it is, and where the rig has it."""
    points = []
    for name in ("table", "wall"):
        corners = world["scene"][f"{name}_corners_m"]
        across, along = ([b - a for a, b in zip(corners[0], corners[k])] for k in (1, 3))
        surface = next(s for s in rig["surface"] if s["name"] == name)
        for i in range(5):
            for j in range(4):
                u, v = 0.1 + 0.2 * i, 0.125 + 0.25 * j
                true = [c + u * x + v * y for c, x, y in zip(corners[0], across, along)]
                turned = recompute.rotate(surface["rotation_qwxyz"], [u * surface["width_mm"], v * surface["height_mm"], 0.0])
                est = [(c + t) / 1000 for c, t in zip(surface["corner_mm"], turned)]
                points.append({"point": len(points), **{f"{k}_{a}_m": p for k, ps in (("true", true), ("est", est)) for a, p in zip("xyz", ps)}})
    return points


def arm_poses(world):
    chance = random.Random(1)
    return [{"pose": i, **{f"joint_{k + 1}_deg": chance.uniform(*limits) for k, limits in enumerate(world["arm"]["joint_range_deg"])}}
            for i in range(JUDGED_POSES)]


def game_rows(drawn, taken):
    """Frames joined by the camera's stamps, which every way of an image keeps; numbered as recompute.py joins them."""
    numbers = {row["camera_stamp_ns"]: row["frame"] for row in taken}
    known = [{**row, "camera_frame": numbers[row["camera_stamp_ns"]]} for row in drawn if row["camera_stamp_ns"] in numbers]
    return known, taken


def figures(test, rig_file, world_file, seed, game=None, name="judged"):
    """Errors to truth of the rig: arm, tip, hand-eye; with game = (poses, exposures), files of the graphics server and of the
    laboratory, of its pictures. `test` is a ProgramTest."""
    raw = os.path.join(test.folder, name, "raw")
    os.makedirs(raw)
    rig = tomllib.loads(test.read(rig_file).decode())
    world = tomllib.loads(test.runs("world", "show", world_file).out)
    truth = {}
    for kind, key in (("arm", "arm"), ("pivot", "pivot"), ("hand-eye", "hand_eye"), ("camera", "camera"), ("pointer", "pointer")):
        test.runs("world", "sample", kind, "--world", world_file, "--seed", seed, "--points", "20", "--out", f"{name}/{kind}")
        truth[key] = json.loads(test.read(name, kind, "truth.json"))
    arm = {"lengths_mm": truth["arm"]["lengths_mm"], **rig["arm"]}
    estimates = {"arm": {"joint": arm}, "pivot": {"tip_mm": rig["arm"]["tip_mm"]}, "hand_eye": rig["hand_eye"]}
    for file, content in (("estimates.json", estimates), ("truth.json", truth)):
        with open(os.path.join(raw, file), "w", encoding="utf-8") as out:
            json.dump(content, out)
    with open(os.path.join(test.folder, name, "summary.json"), "w", encoding="utf-8") as out:
        json.dump({"seed": int(seed), "realtime": {"overlay": {"warm_up_s": WARM_UP_S}}}, out)
    write_rows(os.path.join(raw, "arm_poses.csv"), arm_poses(world))
    if game is not None:
        write_rows(os.path.join(raw, "check_points.csv"), check_points(rig, world))
        seen = rig["camera"]
        lens = {**{k: seen[f"{k}_px"] for k in ("fx", "fy", "cx", "cy")}, "distortion": seen["distortion"]}
        write_rows(os.path.join(raw, "lens.csv"), [lens_row("est", lens), lens_row("true", truth["camera"])])
        for file, rows in zip(("realtime_poses.csv", "realtime_truth.csv"), game_rows(*map(read_rows, game))):
            write_rows(os.path.join(raw, file), rows)
    demo = recompute.Demo(os.path.join(test.folder, name), None, None)

    def differ(message):
        raise AssertionError(message)
    return dict((*recompute.arm_figures(demo), *recompute.offset_figures(demo), *recompute.overlay_figures(demo, differ)))
