#!/usr/bin/env python3
"""A rig as other programs read it: by readers of their own, the arm against its maker's equations."""
import json
import math
import shutil
import subprocess
import unittest
import xml.etree.ElementTree

from program import ProgramTest

try:
    import tomllib
except ImportError:
    tomllib = None
try:
    import yaml
except ImportError:
    yaml = None

ANGLES = ([0.0] * 6, [0.3, -0.2, 0.5, 0.1, 0.7, -0.4], [-0.6, 0.4, -0.3, -1.0, 0.2, 2.0])


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def turn(axis, angle):
    """About one of the axes x, y, z, either way."""
    at = max(range(3), key=lambda k: abs(axis[k]))
    c, s = math.cos(angle), math.sin(angle) * axis[at]
    a, b = (at + 1) % 3, (at + 2) % 3
    m = [[float(i == k) for k in range(4)] for i in range(4)]
    m[a][a], m[a][b], m[b][a], m[b][b] = c, -s, s, c
    return m


def moved(place):
    m = turn((1, 0, 0), 0.0)
    for i in range(3):
        m[i][3] = place[i]
    return m


X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


class Urdf:
    def __init__(self, text):
        self.root = xml.etree.ElementTree.fromstring(text)
        self.above = {joint.find("child").get("link"): joint for joint in self.root.iterfind("joint")}
        self.links = [link.get("name") for link in self.root.iterfind("link")]

    def pose(self, link, angles):
        """Of a link in the root; `angles` by joint."""
        joint = self.above.get(link)
        if joint is None:
            return moved((0, 0, 0))
        origin = joint.find("origin")
        numbers = [[float(x) for x in origin.get(key).split()] for key in ("xyz", "rpy")]
        roll, pitch, yaw = numbers[1]
        own = product(moved(numbers[0]), product(turn(Z, yaw), product(turn(Y, pitch), turn(X, roll))))
        if joint.get("type") in ("continuous", "revolute"):
            mimic = joint.find("mimic")
            angle = angles[joint.get("name")] if mimic is None else float(mimic.get("multiplier")) * angles[mimic.get("joint")]
            own = product(own, turn([float(x) for x in joint.find("axis").get("xyz").split()], angle))
        return product(self.pose(joint.find("parent").get("link"), angles), own)


def phantom(theta, l1, l2):
    """Cavusoglu, Feygin, Tendick (2002), equation 1, and the gimbal about y, x, z."""
    t1, t2, t3, t4, t5, t6 = theta
    reach = l1 * math.cos(t2) + l2 * math.sin(t3)
    place = (math.sin(t1) * reach, l2 - l2 * math.cos(t3) + l1 * math.sin(t2), -l1 + math.cos(t1) * reach)
    pose = moved(place)
    for axis, angle in ((Y, t1), (X, -t3), (Y, t4), (X, t5), (Z, t6)):
        pose = product(pose, turn(axis, angle))
    return pose


def of_quaternion(w, x, y, z, place):
    m = moved(place)
    for i, row in enumerate(((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
                             (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
                             (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))):
        m[i][:3] = row
    return m


class Export(ProgramTest):
    def same(self, found, wanted, delta=1e-9):
        for row, other in zip(found, wanted):
            for a, b in zip(row, other):
                self.assertAlmostEqual(a, b, delta=delta)

    def calibrated(self):
        self.runs("rig", "new", "rig.toml")
        for kind, points in (("camera", 0), ("hand-eye", 0), ("pivot", 0), ("arm", 70), ("surface", 0)):
            self.runs("world", "sample", kind, *(["--points", points] if points else []), "--out", kind)
        for command in (["camera", "--corners", "camera/corners.csv"], ["hand-eye", "--hand", "hand-eye/hand.csv", "--eye", "hand-eye/eye.csv", "--estimate-delay"],
                        ["pivot", "--poses", "pivot/pivot.csv"], ["arm", "--samples", "arm/arm.csv"],
                        ["surface", "--points", "surface/surface.csv", "--name", "table"]):
            self.runs("calibrate", *command, "--rig", "rig.toml")
        return tomllib.loads(self.read("rig.toml").decode())

    @unittest.skipUnless(tomllib, "needs Python 3.11")
    def test_the_arm_is_where_its_makers_equations_put_it(self):
        rig = self.calibrated()
        text = self.runs("export", "rig.toml", "--as", "urdf").out
        urdf = Urdf(text)
        base = of_quaternion(*rig["arm"]["base"]["rotation_qwxyz"], [x / 1000 for x in rig["arm"]["base"]["translation_mm"]])
        l1, l2 = (x / 1000 for x in rig["arm"]["lengths_mm"])
        marker = of_quaternion(*rig["arm"]["marker_in_tip_qwxyz"], (0, 0, 0))
        marker = product(marker, moved([-x / 1000 for x in rig["arm"]["tip_mm"]]))
        for theta in ANGLES:
            names = ["joint_1", "joint_2", "joint_3", "gimbal_1", "gimbal_2", "gimbal_3"]
            tip = product(base, phantom(theta, l1, l2))
            self.same(urdf.pose("tip", dict(zip(names, theta))), tip)
            self.same(urdf.pose("tip_marker", dict(zip(names, theta))), product(tip, marker))
        eye = rig["hand_eye"]
        self.same(urdf.pose("camera_optical", {}), of_quaternion(*eye["rotation_qwxyz"], [x / 1000 for x in eye["translation_mm"]]))
        self.assertIn("table", urdf.links)
        self.assertIn(f"gains {rig['arm']['gains'][0]}", text, "what URDF has no place for")
        if shutil.which("check_urdf"):
            self.write("arm.urdf", text)
            done = subprocess.run(["check_urdf", self.path("arm.urdf")], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_chain_is_where_its_rows_put_it(self):
        rows = [(0.1, 90.0, 50.0, 10.0), (200.0, 0.0, 0.0, -20.0), (30.0, -90.0, 40.0, 0.0), (0.0, 35.0, 150.0, 90.0)]
        self.write("chain.toml", 'type = "dh"\ntool_mm = [3, 4, 80]\n' + "".join(
            f"[[joint]]\na_mm = {a}\nalpha_deg = {alpha}\nd_mm = {d}\ntheta_offset_deg = {offset}\n" for a, alpha, d, offset in rows))
        self.runs("rig", "new", "rig.toml")

        def tip(theta):
            pose = moved((0, 0, 0))
            for (a, alpha, d, offset), angle in zip(rows, theta):
                pose = product(pose, product(turn(Z, angle + math.radians(offset)), product(moved((a / 1000, 0, d / 1000)), turn(X, math.radians(alpha)))))
            return product(pose, moved((0.003, 0.004, 0.08)))

        header = ",".join(f"joint_{i}_deg" for i in range(1, 5)) + ",x_mm,y_mm,z_mm\n"
        thetas = [[0.8 * math.sin(k * (1.3 + 0.7 * i) + i) for i in range(4)] for k in range(60)]
        self.write("arm.csv", header + "".join(",".join(str(math.degrees(t)) for t in theta) + "," + ",".join(str(1000 * tip(theta)[i][3]) for i in range(3)) + "\n"
                                               for theta in thetas))
        self.runs("calibrate", "arm", "--arm", "chain.toml", "--samples", "arm.csv", "--free", "gains", "--rig", "rig.toml")
        urdf = Urdf(self.runs("export", "rig.toml", "--as", "urdf").out)
        for theta in thetas[:5]:
            angles = {f"joint_{i + 1}": t for i, t in enumerate(theta)} | {f"gimbal_{i}": 0.0 for i in (1, 2, 3)}
            found, wanted = urdf.pose("tip", angles), tip(theta)
            for i in range(3):
                self.assertAlmostEqual(found[i][3], wanted[i][3], delta=2e-6)
        self.assertIn("written to again.toml", self.runs("export", "rig.toml", "--as", "arm", "--out", "again.toml").out)
        self.runs("calibrate", "arm", "--arm", "again.toml", "--samples", "arm.csv", "--free", "gains")

    @unittest.skipUnless(tomllib and yaml, "needs Python 3.11 and PyYAML")
    def test_lens_transforms_and_points_are_read_by_others_and_back(self):
        rig = self.calibrated()
        info = yaml.safe_load(self.runs("export", "rig.toml", "--as", "camera-info").out)
        self.assertEqual(info["camera_matrix"]["data"][0], rig["camera"]["fx_px"])
        self.assertEqual(info["distortion_coefficients"]["data"], rig["camera"]["distortion"])
        self.assertEqual((info["image_width"], info["image_height"]), (rig["camera"]["width_px"], rig["camera"]["height_px"]))
        turned = yaml.safe_load(self.runs("export", "rig.toml", "--as", "easy-handeye", "--part", "hand-eye").out)["transformation"]
        for key, value in zip("xyz", rig["hand_eye"]["translation_mm"]):
            self.assertAlmostEqual(turned[key], value / 1000, delta=1e-12)
        self.refuses(["export", "rig.toml", "--as", "urdf", "--out", "./rig.toml"], 2, "is the rig itself")
        self.refuses(["export", "rig.toml", "--as", "matrix"], 2, "several", "hand-eye, arm-base, tip, table", "--part")
        self.refuses(["export", "rig.toml", "--as", "matrix", "--part", "wall"], 2, "no part 'wall'", "hand-eye")
        self.refuses(["export", "rig.toml", "--as", "tfm", "--part", "camera"], 2, "a lens cannot be written as tfm")
        matrix = [[float(x) for x in line.split()] for line in self.runs("export", "rig.toml", "--as", "matrix", "--part", "arm-base").out.splitlines()]
        self.same(matrix, of_quaternion(*rig["arm"]["base"]["rotation_qwxyz"], rig["arm"]["base"]["translation_mm"]), 1e-9)
        points = json.loads(self.runs("export", "rig.toml", "--as", "mrk-json").out)["markups"][0]["controlPoints"]
        self.assertEqual([point["label"] for point in points], [f"table_{i}" for i in range(1, 5)])
        # What the program has written it reads again.
        for form, part, name in (("opencv", "camera", "lens.yml"), ("camera-info", "camera", "lens.yaml"), ("json", "camera", "lens.json")):
            self.runs("export", "rig.toml", "--as", form, "--part", part, "--out", name)
            self.runs("convert", name, "again.json")
            self.assertEqual(json.loads(self.read("again.json"))["fx"], rig["camera"]["fx_px"])
        for form, name in (("easy-handeye", "he.yaml"), ("tfm", "he.tfm"), ("matrix", "he.txt")):
            self.runs("export", "rig.toml", "--as", form, "--part", "hand-eye", "--out", name)
            self.runs("convert", name, "again.txt")
            again = [[float(x) for x in line.split()] for line in self.read("again.txt").decode().splitlines()]
            self.same(again, of_quaternion(*rig["hand_eye"]["rotation_qwxyz"], rig["hand_eye"]["translation_mm"]), 1e-9)

    def test_what_a_rig_has_not_is_refused(self):
        self.runs("rig", "new", "rig.toml")
        self.refuses(["export", "rig.toml", "--as", "urdf"], 1, "calibrate arm")
        self.refuses(["export", "rig.toml", "--as", "opencv"], 1, "rig.toml: holds nothing that is written as opencv", "calibrate first")
        self.refuses(["export", "rig.toml", "--as", "stl"], 2, "--as", "urdf")
        self.refuses(["export", "nowhere.toml", "--as", "urdf"], 2, "nowhere.toml")
        self.runs("export", "rig.toml", "--as", "arm", "--out", "arm.toml")
        self.assertIn("lengths_mm", self.read("arm.toml").decode())


if __name__ == "__main__":
    unittest.main()
