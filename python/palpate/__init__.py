"""Palpate from Python: calibrations of arm, tracker, camera and surfaces on numpy arrays, readers of their files, a client of
running sessions, sessions in the simulated laboratory, experiments and sweeps.

    import palpate
    result = palpate.calibrate_pivot(poses, time=seconds)
    print(result)                      # tip, standard deviations, warnings
    result.tip, result.tip_std, result.covariance, result.to_dict()

    with palpate.Client() as client:   # of the physics server that runs here
        for block in client.states():  # every step of its world
            print(block.positions[:, 0])

Metres, seconds, radians; a pose is a 4 x 4 matrix. `palpate.Refused` says that data cannot carry an answer.
"""
import importlib.util as _util

if _util.find_spec(f"{__name__}._core") is None:
    raise ImportError(f"palpate: {__path__[0]} is without its compiled part: remove it from PYTHONPATH and sys.path where it is "
                      "the source tree, and build or install the package (docs/guides/python.md, Install)")

from ._calibrate import (absolute_orientation, calibrate_arm, calibrate_camera, calibrate_delay, calibrate_hand_eye,
                         calibrate_landmarks, calibrate_pivot, calibrate_surface, calibrate_surfaces)
from ._client import Body, Client, SceneSurface, ServerClock, States, Watch
from ._files import ArmSamples, BoardViews, Points, find_corners, read_arm_samples, read_corners, read_points
from ._lockstep import LockstepResult, Session, lockstep, study
from ._poses import Poses, poses_from_quaternions, read_poses
from ._psychometric import PsychometricFit, fit_psychometric, spread_of_weber_fraction, weber_fraction
from ._recording import Recording, Topic
from ._refused import Refused
from ._results import (ArmResult, CameraResult, DelayResult, HandEyeResult, LandmarksResult, PivotResult, Result,
                       RigidMotionResult, SurfaceResult)
from ._rig import Rig, RigSurface
from ._staircase import InterleavedStaircases, Observer, Staircase, StaircaseRule, StaircaseThreshold, practised_weber_fraction
from ._states import State, StateBlock
from ._sweep import grid, sweep
from ._trials import Conditions, ExperimentRun, Trial, example_conditions

__all__ = [
    "ArmResult", "ArmSamples", "BoardViews", "Body", "CameraResult", "Client", "Conditions", "DelayResult", "ExperimentRun",
    "HandEyeResult", "InterleavedStaircases", "LandmarksResult", "LockstepResult", "Observer", "PivotResult", "Points", "Poses",
    "PsychometricFit", "Recording", "Refused", "Result", "Rig", "RigSurface", "RigidMotionResult", "SceneSurface",
    "ServerClock", "Session", "Staircase", "StaircaseRule", "StaircaseThreshold", "State", "StateBlock", "States",
    "SurfaceResult", "Topic", "Trial", "Watch", "absolute_orientation", "calibrate_arm", "calibrate_camera", "calibrate_delay",
    "calibrate_hand_eye", "calibrate_landmarks", "calibrate_pivot", "calibrate_surface", "calibrate_surfaces",
    "example_conditions", "find_corners", "fit_psychometric", "grid", "lockstep", "poses_from_quaternions",
    "practised_weber_fraction", "read_arm_samples", "read_corners", "read_points", "read_poses", "spread_of_weber_fraction",
    "study", "sweep", "weber_fraction",
]
