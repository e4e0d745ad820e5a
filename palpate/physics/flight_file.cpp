#include "palpate/physics/flight_file.h"

#include <array>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/units.h"

namespace palpate::physics {

Expected<std::vector<SeenBall>> read_flight(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_flight(*content, path.string());
}

Expected<std::vector<SeenBall>> parse_flight(std::string_view content, std::string source) {
  const auto table = parse_csv(content, std::move(source));
  if (!table) return tl::unexpected(table.error());
  std::array<std::size_t, 4> column{};
  constexpr std::array kNames = {"t_s", "x_m", "y_m", "z_m"};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto found = table->require(kNames[i]);
    if (!found) return tl::unexpected(found.error());
    column[i] = *found;
  }
  constexpr double kLongestFlight = 60.0;  // s: a ball that is hit by hand; longer ones would only take long
  if (const auto fine = table->require_within({column[0]}, kLatestTime); !fine)
    return tl::unexpected(fine.error());
  if (const auto fine = table->require_within({column[1], column[2], column[3]}, kFarthestPlace); !fine)
    return tl::unexpected(fine.error());
  std::vector<SeenBall> balls;
  for (const auto& row : table->rows) {
    const SeenBall ball{row[column[0]], {row[column[1]], row[column[2]], row[column[3]]}};
    if (balls.empty() || ball.time > balls.back().time) balls.push_back(ball);
  }
  if (!balls.empty() && balls.back().time - balls.front().time > kLongestFlight)
    return wrong_use("{}: lasts {:.3g} s; one flight of at most {:g} s is expected, check the unit of t_s",
                     table->source, balls.back().time - balls.front().time, kLongestFlight);
  if (balls.empty())
    return wrong_use("{}: holds a header but no balls; at least one row is expected", table->source);
  return balls;
}

}  // namespace palpate::physics
