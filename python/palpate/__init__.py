"""Palpate from Python: calibrations of arm, tracker, camera and surfaces on numpy arrays, and readers of their files.

    import palpate
    result = palpate.calibrate_pivot(poses, time=seconds)
    print(result)                      # tip, standard deviations, warnings
    result.tip, result.tip_std, result.covariance, result.to_dict()

Metres, seconds, radians; a pose is a 4 x 4 matrix. `palpate.Refused` says that data cannot carry an answer.
"""
from ._calibrate import (absolute_orientation, calibrate_arm, calibrate_camera, calibrate_delay, calibrate_hand_eye,
                         calibrate_landmarks, calibrate_pivot, calibrate_surface, calibrate_surfaces)
from ._files import ArmSamples, BoardViews, Points, find_corners, read_arm_samples, read_corners, read_points
from ._poses import Poses, poses_from_quaternions, read_poses
from ._recording import Recording, Topic
from ._refused import Refused
from ._results import (ArmResult, CameraResult, DelayResult, HandEyeResult, LandmarksResult, PivotResult, Result,
                       RigidMotionResult, SurfaceResult)
from ._rig import Rig, RigSurface

__all__ = [
    "ArmResult", "ArmSamples", "BoardViews", "CameraResult", "DelayResult", "HandEyeResult", "LandmarksResult", "PivotResult",
    "Points", "Poses", "Recording", "Refused", "Result", "Rig", "RigSurface", "RigidMotionResult", "SurfaceResult", "Topic", "absolute_orientation",
    "calibrate_arm", "calibrate_camera", "calibrate_delay", "calibrate_hand_eye", "calibrate_landmarks", "calibrate_pivot",
    "calibrate_surface", "calibrate_surfaces", "find_corners", "poses_from_quaternions", "read_arm_samples", "read_corners",
    "read_points", "read_poses",
]
