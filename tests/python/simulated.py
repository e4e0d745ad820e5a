"""Simulated measurements of the tests: numpy alone, nothing of the package."""
import numpy as np


def turn(vector):
    """The matrix of a rotation by |vector| about it (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def matrices(rotations, positions):
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = rotations, positions
    return poses


def simulated_pivot(random, count=200, noise=0.2e-3, tip=(0.004, -0.012, -0.153), pivot=(0.1, 0.2, -0.9)):
    """Poses of a marker while its tip rests; white noise on the places, m."""
    rotations = np.array([turn(vector) for vector in random.uniform(-0.6, 0.6, (count, 3))])
    positions = np.array(pivot) - rotations @ np.array(tip) + noise * random.standard_normal((count, 3))
    return matrices(rotations, positions), np.array([*tip, *pivot])


LENGTHS = (0.20955, 0.20955)  # m, of a Phantom Premium 1.5


def phantom_tips(theta):
    """The tip in the arm's base at corrected angles (N, 3); the origin is the tip where all are 0."""
    l1, l2 = LENGTHS
    s, c = np.sin(theta), np.cos(theta)
    reach = l1 * c[:, 1] + l2 * s[:, 2]
    return np.stack([s[:, 0] * reach, l2 - l2 * c[:, 2] + l1 * s[:, 1], -l1 + c[:, 0] * reach], axis=1)


class SimulatedArm:
    """An arm with errors of its joints, drawn anew; its tip measured with white noise."""

    def __init__(self, random, noise=0.1e-3):
        self.random, self.noise = random, noise
        self.gains = 1.0 + 0.01 * random.standard_normal(3)
        # The first joint's offset and the base's turn about that axis are one and the same: nobody can tell them apart.
        self.offsets = np.array([0.0, *(0.02 * random.standard_normal(2))])
        self.base = matrices([turn(random.uniform(-0.5, 0.5, 3))], [random.uniform(-0.5, 0.5, 3)])[0]

    def readings(self, count):
        """Encoder readings, rad, uniform over a part of the workspace in which the arm is not folded up."""
        return self.random.uniform((-0.6, -0.1, -0.4), (0.6, 0.9, 0.5), (count, 3))

    def tips(self, readings):
        """Where the tip truly is, in the world."""
        return phantom_tips(readings * self.gains + self.offsets) @ self.base[:3, :3].T + self.base[:3, 3]

    def measured(self, readings):
        return self.tips(readings) + self.noise * self.random.standard_normal((len(readings), 3))
