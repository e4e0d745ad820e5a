// What the header of somebody's table says: which columns are the pose of which body, which the time.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::formats {

struct BodyColumns {
  std::string name;                  // empty: the table says none
  std::array<std::size_t, 7> at{};   // x y z, qw qx qy qz
  std::optional<std::size_t> state;  // a word; what is not OK was not seen
  bool euler_degrees = false;        // at[3..5] are Rz Ry Rx, degrees, as NDI's programs have them
  double metres_per_unit = 0.0;      // 0: nobody says
};

struct PointColumns {
  std::array<std::size_t, 3> at{};
  std::optional<std::size_t> label;
  double metres_per_unit = 0.0;  // 0: nobody says
};

enum class TimeForm {
  none,
  seconds,
  milliseconds,
  microseconds,
  nanoseconds,
  seconds_and_nanoseconds,
  time_of_day
};

struct TimeColumns {
  TimeForm form = TimeForm::none;
  std::array<std::size_t, 4> at{};  // one; s and ns; hours, minutes, s and ms
};

struct TableHeader {
  std::string form, told;
  bool own = false;  // columns of this program's tables
  std::vector<BodyColumns> bodies;
  std::optional<PointColumns> points;  // where there is no body
  TimeColumns time;
  // Why its columns are nobody's, in words; what there is of bodies and points is not to be read then.
  std::string cannot;
};

// Nothing where these are no names of a pose's columns, nor of a point's.
std::optional<TableHeader> understand_header(const std::vector<std::string_view>& names);

}  // namespace palpate::formats
