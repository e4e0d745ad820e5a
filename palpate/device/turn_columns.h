// Columns that tell how a body is turned, by their names, whether they are read or not.
#pragma once

#include <span>
#include <string>

namespace palpate::device {

// "roll,pitch,yaw": the header's names for a part of a quaternion, for angles or a rotation, as far as they are usual;
// empty where there are none.
std::string turn_columns(std::span<const std::string> header);

}  // namespace palpate::device
