"""Laboratory, physics server and graphics server as three processes, for the tests of servers."""
import importlib
import os
import signal
import subprocess
import sys
import tomllib

from program import ProgramTest, wait_until

READY = {"world": "are open", "physics": "answers graphics servers at", "graphics": "shows pingpong"}
DEVICES = tuple(f"palpate: graphics: {device}" for device in ("camera: ", "camera ", "right camera", "tracker: ", "landmarks: "))  # their conditions
UNPROTECTED = "not protected from load"  # where the machine grants no real-time rights
GONE, BACK = "no longer answers", "answers again"


def told(done):
    """What a server said beside that it was ready. A machine so busy that the physics server or a device missed a beat is no matter."""
    known = (*READY.values(), UNPROTECTED)
    lines = [line for line in done.lines if not any(words in line for words in known) and not line.startswith(DEVICES)]
    while (at := next((i for i in range(len(lines) - 1) if GONE in lines[i] and BACK in lines[i + 1]), None)) is not None:
        del lines[at:at + 2]
    return lines


def calibrate(runs):
    """rig.toml from samples of the simulated laboratory; runs(*arguments) runs the program in one folder."""
    for kind in ("arm", "camera", "hand-eye", "surface"):
        runs("world", "sample", kind, "--out", "samples")
    runs("rig", "new", "rig.toml")
    for kind in (["arm", "--arm", "phantom-premium-1.5", "--samples", "samples/arm.csv"], ["camera", "--corners", "samples/corners.csv"],
                 ["hand-eye", "--estimate-delay", "--hand", "samples/hand.csv", "--eye", "samples/eye.csv"],
                 ["surface", "--points", "samples/surface.csv"], ["surface", "--points", "samples/wall.csv"]):
        runs("calibrate", *kind, "--rig", "rig.toml")


class LaboratoryTest(ProgramTest):
    _rig = None  # calibrated once, from samples of the simulated laboratory

    def wire_messages(self):
        """The messages between the servers, as Python knows them, compiled from the protocol's own file."""
        protocol = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../proto")
        subprocess.run(["protoc", f"-I{protocol}", f"--python_out={self.root}", "palpate.proto"], check=True)
        sys.path.append(self.root)
        self.addCleanup(sys.path.remove, self.root)
        return importlib.import_module("palpate_pb2")

    def setUp(self):
        super().setUp()
        self.state = os.path.join(self.root, "state")
        if LaboratoryTest._rig is None:
            calibrate(self.runs)
            LaboratoryTest._rig = self.read("rig.toml")
        self.rig = self.write("rig.toml", LaboratoryTest._rig)

    def mark_checked(self, arm, *more):
        """Puts into the rig that the forces of this arm have been checked, as `calibrate forces` does; `more`: further lines."""
        text = self.read("rig.toml").decode()
        rig = tomllib.loads(text)
        known, nominal = rig["arm"], rig["nominal_arm"]
        self.write("rig.toml", "\n".join((
            text, "[forces]", f'arm = "{arm}"', f'model = "{known["model"]}"',
            f"model_lengths_mm = {known['lengths_mm']}", "model_angles_deg = []",
            f"nominal_lengths_mm = {nominal['lengths_mm']}", "nominal_angles_deg = []", f"gains = {known['gains']}", f"rest_readings_deg = {known.get('rest_readings_deg', [0, 0, 0])}",
            f"offsets_deg = {known['offsets_deg']}", "map = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "joint_gains = [1, 1, 1]", *more, "")).encode())

    def start_world(self, *options):
        world = self.start("world", "run", *options)
        self.assertTrue(world.says(READY["world"]), world.lines())
        return world

    def start_physics(self, *options):
        physics = self.start("physics", "--rig", self.rig, *options)
        self.assertTrue(physics.says(READY["physics"]), physics.lines())
        return physics

    def start_graphics(self, *options):
        graphics = self.start("graphics", "--rig", self.rig, *options)
        self.assertTrue(graphics.says(READY["graphics"]), graphics.lines())
        return graphics

    def start_all(self):
        return self.start_world(), self.start_physics(), self.start_graphics()

    def stop_in_order(self, *servers, number=signal.SIGTERM):
        """Each ends at once with exit 0 and its figures; returns what each said."""
        said = []
        for server in servers:
            server.send(number)
            done = server.ends()
            self.assertEqual(done.code, 0, f"{server.arguments}: {done}")
            self.assertEqual(len(done.out.splitlines()), 1, done)
            said.append(told(done))
        return said

    def left_behind(self):
        """Sockets and shared memory; lock files that nobody holds block nobody, and what forces did before a trip is to stay."""
        place = os.path.join(self.meeting, "palpate")
        return [name for name in os.listdir(place) if not name.endswith(".lock") and not name.startswith(("trip_", "realtime_trips."))] if os.path.isdir(place) else []

    def catches(self, running, number):
        """Waits until the process has a handler for the signal."""
        def caught():
            with open(f"/proc/{running.process.pid}/status", encoding="ascii") as status:
                mask = next(line for line in status if line.startswith("SigCgt")).split()[1]
            return int(mask, 16) >> (number - 1) & 1
        wait_until(lambda: running.ended() or caught(), f"{running.arguments} catches signal {number}")

    def stands(self, words=""):
        """Tells a stand-in for a maker's library how its device stands (HD_STUB_STATE, DHD_STUB_STATE)."""
        with open(self.state + ".new", "w", encoding="ascii") as file:
            file.write(words)
        os.replace(self.state + ".new", self.state)


class StandInArmTest(LaboratoryTest):
    """With a stand-in for the maker's library of OpenHaptics: its arm's hand, buttons, motors and cable are told through a file."""
    ARM = "openhaptics Simulated PHANToM 0042"

    def setUp(self):
        super().setUp()
        self.environment.update(PALPATE_LIBHD=os.environ["HD_STUB"], HD_STUB_STATE=self.state)
        self.environment.pop("GTDD_HOME", None)
