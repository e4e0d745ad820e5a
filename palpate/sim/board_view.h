// Where a camera sees the corners of the calibration board: true places with the noise of finding them.
//
// Pixels through the lens; board of 9 x 6 inner corners. Stands for drawing and detecting where pictures are
// not wanted. Pure functions, safe from any thread.
#pragma once

#include <optional>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/device/camera_model.h"

namespace palpate::sim {

inline constexpr int kBoardColumns = 9, kBoardRows = 6;
inline constexpr double kBoardSquare = 0.025;  // m
inline constexpr double kCornerNoise = 0.1;    // px, sd of a corner found in a sharp picture
inline constexpr double kPictureMargin = 4.0;  // px: nearer to the edge a corner cannot be found

// All corners row by row, or none where one lies outside the picture or behind the camera.
std::optional<std::vector<device::Pixel>> board_corners(const device::CameraModel& lens,
                                                        const Pose<CameraOptical, Board>& X_camera_board,
                                                        double noise_sd, Random& random);

// Poses in which a person would hold the board up to a camera that is to be calibrated: whole in the picture,
// near and far, tilted both ways, reaching its edges.
std::vector<Pose<CameraOptical, Board>> board_poses(const device::CameraModel& lens, int count,
                                                    Random& random);

}  // namespace palpate::sim
