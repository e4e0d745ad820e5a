// Recorded ball flights: CSV `t_s,x_m,y_m,z_m`, more columns allowed. SI; the frame is the recording's. Rows
// whose time does not increase are left out. Errors: wrong use, with file and line.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/flight.h"

namespace palpate::physics {

Expected<std::vector<SeenBall>> read_flight(const std::filesystem::path& path);
Expected<std::vector<SeenBall>> parse_flight(std::string_view content, std::string source);

}  // namespace palpate::physics
