// Transform sequences of PLUS and 3D Slicer (.igs.mha): the text header of a MetaImage file, one set of named
// 4x4 matrices per frame (`Seq_Frame0007_StylusToTrackerTransform = 16 numbers`), translations in mm.
//
// The wanted transform may be one of those in the file, the inverse of one, or a chain of them:
// StylusToReference from StylusToTracker and ReferenceToTracker. Frames in which a needed transform has a
// status other than OK are left out. Errors: wrong use. Format: IGSIO, "Sequence file (.igs.mha)".
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/pose_file.h"

namespace palpate::device {

bool is_transform_sequence(std::string_view content);

// Names of the transforms there are ("StylusToTracker"), each once, in alphabetical order.
std::vector<std::string> transform_names(std::string_view content);

// `transform` may be empty where the file has only one. `left_out` becomes the number of frames that are not among the poses.
Expected<std::vector<StampedPose>> parse_transform_sequence(std::string_view content,
                                                            const std::string& source,
                                                            const std::string& transform,
                                                            std::size_t* left_out = nullptr);

}  // namespace palpate::device
