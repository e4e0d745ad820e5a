"""A rig whose arm states its place, and a session with such an arm from outside the laboratory."""
import json
import math
import re
import signal
import tomllib

from laboratory import LaboratoryTest
from program import wait_until

# An arm that stands with its axes along those of the room: the place it states is the place in the room.
ARM = """[nominal_arm]
name = "delta"
type = "cartesian"
range_mm = [[-2000, 2000], [-2000, 2000], [-2000, 2000]]

[arm]
model = "delta"
type = "cartesian"
range_mm = [[-2000, 2000], [-2000, 2000], [-2000, 2000]]
tip_mm = [0, 0, -118]
marker_in_tip_qwxyz = [1, 0, 0, 0]
gimbal_gains = [1, 1, 1]
gimbal_offsets_deg = [0, 0, 0]
rest_readings_mm = [0, 0, 0]

[arm.base]
rotation_qwxyz = [1, 0, 0, 0]
translation_mm = [0, 0, 0]
"""
CHECKED = """
[forces]
arm = "IDENTITY"
model = "delta"
model_lengths_mm = [-2000, 2000, -2000, 2000, -2000, 2000, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
model_angles_deg = []
nominal_lengths_mm = [-2000, 2000, -2000, 2000, -2000, 2000, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
nominal_angles_deg = []
gains = [1, 1, 1]
rest_readings_mm = [0, 0, 0]
offsets_mm = [0, 0, 0]
map = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
joint_gains = [1, 1, 1]"""


class CartesianArmTest(LaboratoryTest):
    def setUp(self):
        super().setUp()
        text = self.read("rig.toml").decode()
        # All tables but those of the laboratory's arm.
        parts = re.split(r"(?m)^(?=\[)", text)
        kept = [part for part in parts if not part.startswith(("[arm", "[nominal_arm"))]
        self.text = "".join(kept) + "\n" + ARM
        self.write("rig.toml", self.text)

    def mark_checked(self, arm, *more):
        self.write("rig.toml", "\n".join((self.text + CHECKED.replace("IDENTITY", arm), *more, "")))
        self.assertIn(f"checked on {arm}", self.runs("rig", "show", self.rig).out)

    def condition(self):
        return json.loads(self.runs("status", "--json", "-").out)["loops"][0]["condition"]

    def stop(self, physics):
        physics.send(signal.SIGTERM)
        done = physics.ends()
        self.assertEqual(done.code, 0, done)

    def table(self):
        """A place over the middle of what `touch` has on the table (80 mm to the right, 70 mm from the near edge), and the way up; metres."""
        table, = (surface for surface in tomllib.loads(self.text)["surface"] if surface["name"] == "table")
        w, x, y, z = table["rotation_qwxyz"]
        axes = ((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
                (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)))
        up = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
        sides = (table["width_mm"], table["height_mm"])
        near, right = (0, 1) if abs(axes[0][2]) > abs(axes[1][2]) else (1, 0)  # the person sits along z of the room
        place = [c + 0.5 * (sides[0] * a + sides[1] * b) for c, a, b in zip(table["corner_mm"], *axes)]
        along = math.copysign(0.5 * sides[near] - 70.0, axes[near][2])
        across = math.copysign(80.0, axes[right][0])
        return [1e-3 * (p + along * n + across * r) for p, n, r in zip(place, axes[near], axes[right])], up

    def over_the_pad(self, height):
        middle, up = self.table()
        return [m + height * u for m, u in zip(middle, up)]

    def lower_through_the_pad(self, hold, until):
        """From 0.3 m above it, slowly enough for the guard; `hold` puts the arm at a place."""
        height = 0.30

        def there():
            nonlocal height
            height = max(-0.01, height - 0.0005)
            hold(self.over_the_pad(height))
            return until(height)
        wait_until(there, "it is through the pad's surface")
