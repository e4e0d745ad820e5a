// A lens under the names that OpenCV's programs, ROS and others give its parts.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/formats/content.h"

namespace palpate::formats {

// What a file has under a key: the numbers of a matrix row by row, of a list, or one number; nothing where it has no such key,
// one NaN where what stands there are no numbers.
using NumbersAt = std::function<std::optional<std::vector<double>>(const std::string& key)>;

// "camera_matrix", or what others call it, is there.
bool has_lens(const NumbersAt& numbers_at);
// Wrong use where it is not whole, or has terms that our models have not: a thin prism, a tilted sensor. `model`: what the file calls
// its lens; empty: nothing.
// The keys of the camera that is `wanted`, where a file has those of two (M1, D1 and M2, D2, as OpenCV's stereo programs). Wrong use
// where it holds two and none is named, and where one is named of a file that holds one.
Expected<NumbersAt> one_camera(const NumbersAt& numbers_at, const std::string& wanted,
                               const std::string& source);
// Its unit and its coefficients' names, for a person.
std::string told_of(const Lens& lens);
Expected<Lens> lens_of(const NumbersAt& numbers_at, const std::string& model, const std::string& source);

}  // namespace palpate::formats
