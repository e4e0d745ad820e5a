"""Palpate from Python: calibrations of arm, tracker, camera and surfaces on numpy arrays, readers of their files, and a client
of running sessions.

    import palpate
    result = palpate.calibrate_pivot(poses, time=seconds)
    print(result)                      # tip, standard deviations, warnings
    result.tip, result.tip_std, result.covariance, result.to_dict()

    with palpate.Client() as client:   # of the physics server that runs here
        for block in client.states():  # every step of its world
            print(block.positions[:, 0])

Metres, seconds, radians; a pose is a 4 x 4 matrix. `palpate.Refused` says that data cannot carry an answer.
"""
from ._calibrate import (absolute_orientation, calibrate_arm, calibrate_camera, calibrate_delay, calibrate_hand_eye,
                         calibrate_landmarks, calibrate_pivot, calibrate_surface, calibrate_surfaces)
from ._client import Body, Client, SceneSurface, ServerClock, States, Watch
from ._files import ArmSamples, BoardViews, Points, find_corners, read_arm_samples, read_corners, read_points
from ._poses import Poses, poses_from_quaternions, read_poses
from ._recording import Recording, Topic
from ._refused import Refused
from ._results import (ArmResult, CameraResult, DelayResult, HandEyeResult, LandmarksResult, PivotResult, Result,
                       RigidMotionResult, SurfaceResult)
from ._rig import Rig, RigSurface
from ._states import State, StateBlock

__all__ = [
    "ArmResult", "ArmSamples", "BoardViews", "Body", "CameraResult", "Client", "DelayResult", "HandEyeResult", "LandmarksResult",
    "PivotResult", "Points", "Poses", "Recording", "Refused", "Result", "Rig", "RigSurface", "RigidMotionResult", "SceneSurface",
    "ServerClock", "State", "StateBlock", "States", "SurfaceResult", "Topic", "Watch", "absolute_orientation", "calibrate_arm",
    "calibrate_camera", "calibrate_delay", "calibrate_hand_eye", "calibrate_landmarks", "calibrate_pivot", "calibrate_surface",
    "calibrate_surfaces", "find_corners", "poses_from_quaternions", "read_arm_samples", "read_corners", "read_points", "read_poses",
]
