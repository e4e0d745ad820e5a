// Which corners of a ChArUco board are in an image, and where; and where that puts the camera.
//
// Pixels as CameraModel has them: (0,0) is the centre of the first pixel, the lens still in them. An inner
// corner counts where both markers beside it were read, and is refined in a window that holds no edge of
// theirs. Functions without state, safe from any thread; 5 to 10 ms for 640x480 px. A board that is not seen
// is no error but an empty sight. Source: OpenCV's marker detector (Garrido-Jurado et al. 2014) and sub-pixel
// refinement (Foerstner & Guelch 1987); the pose is pose_refinement.h's, its start board_pose's (IPPE,
// Collins & Bartoli 2014).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/device/charuco_board.h"
#include "palpate/vision/board.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate::vision {

struct CharucoSight {
  std::vector<int> corners;           // of the board, rising
  std::vector<device::Pixel> pixels;  // where they are
  int markers = 0;                    // of the board, read
  int contradictions = 0;             // corners that the two markers beside them put at different places
  int strangers = 0;                  // markers of the same dictionary that the board does not have
};

CharucoSight find_charuco(std::span<const std::uint8_t> grey, int width, int height,
                          const device::CharucoBoard& board);

// The view as lens calibration and board_pose want it.
BoardView charuco_view(const device::CharucoBoard& board, const CharucoSight& sight, std::string name);

// Every image file the pattern names; an image with fewer than six corners, or with corners in one row, is
// among not_found.
Expected<BoardViews> read_charuco_images(const std::string& pattern, const device::CharucoBoard& board);

// Another dictionary of which at least three markers are in the image: the wrong board lies there. Slow
// (some 0.1 s): for when nothing else is to be done.
std::optional<std::string> other_dictionary(std::span<const std::uint8_t> grey, int width, int height,
                                            const std::string& than);

// The inner corners as landmarks in World, known to 0.1 mm: what a printer and flat paper leave.
std::vector<rig::Landmark> charuco_landmarks(const device::CharucoBoard& board,
                                             const Pose<World, Board>& X_world_board);

// px per axis: what a corner is off by noise and by edges that are not ideal.
inline constexpr double kCharucoCornerSd = 0.1;

// The camera's pose from the board alone. `near`: where it was a moment ago, if that is known; it decides
// between the two tilts that a small board allows, and has no other weight. Refused, with the reason in
// words, where the board does not say: too few corners, two tilts that fit alike, corners that do not lie as
// on this board.
Expected<RefinedPose> camera_from_charuco(const device::CameraModel& camera,
                                          const device::CharucoBoard& board,
                                          const Pose<World, Board>& X_world_board, const CharucoSight& sight,
                                          const std::optional<Pose<World, CameraOptical>>& near);

// A marker's bits, row by row with its black border: true is black. `id` of the dictionary.
std::vector<std::vector<bool>> charuco_bits(const std::string& dictionary, int id);

}  // namespace palpate::vision
