// What the steps of a calibration session have found, in a line each, with the figure that tells a good result from
// a poor one.
//
// Of a rig that has the step's part. Lengths in mm, angles in degrees, as people read them. Pure.
#pragma once

#include <string>

#include "palpate/rig/rig.h"

namespace palpate::calibration::session {

std::string words_of_pivot(const rig::PivotCalibration& pivot);
std::string words_of_surfaces(const rig::Rig& rig);
std::string words_of_landmarks(const rig::Rig& rig);
std::string words_of_arm(const rig::ArmCalibration& arm);
std::string words_of_delay(double delay_s, double std_s);
std::string words_of_camera(const rig::CameraCalibration& camera, const rig::HandEyeCalibration& hand_eye);
// How well the landmarks lie, by their covariances.
std::string words_of_places(const rig::Rig& rig);

}  // namespace palpate::calibration::session
