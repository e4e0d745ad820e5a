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
