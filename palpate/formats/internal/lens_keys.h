// A lens under the names that OpenCV's programs, ROS and others give its parts.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/formats/content.h"

namespace palpate::formats {

// What a file has under a key: the numbers of a matrix row by row, of a list, or one number; nothing where it has none.
using NumbersAt = std::function<std::optional<std::vector<double>>(const std::string& key)>;

// "camera_matrix", or what others call it, is there.
bool has_lens(const NumbersAt& numbers_at);
// Wrong use where it is not whole, or has terms that our models have not: a thin prism, a tilted sensor. `model`: what the file calls
// its lens; empty: nothing.
// Its unit and its coefficients' names, for a person.
std::string told_of(const Lens& lens);
Expected<Lens> lens_of(const NumbersAt& numbers_at, const std::string& model, const std::string& source);

}  // namespace palpate::formats
