#include "palpate/formats/internal/table_header.h"

#include <algorithm>
#include <array>

#include "palpate/core/lower_case.h"
#include "palpate/core/text.h"
#include "palpate/device/turn_columns.h"
#include "palpate/formats/internal/text_table.h"

namespace palpate::formats {
namespace {

using Names = std::vector<std::string>;

constexpr const char* kTum = "a TUM trajectory";

std::optional<std::size_t> find(const Names& names, std::string_view name) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  return static_cast<std::size_t>(at - names.begin());
}

template <std::size_t N>
std::optional<std::array<std::size_t, N>> find_all(const Names& names, const std::string& prefix,
                                                   const std::array<const char*, N>& rest) {
  std::array<std::size_t, N> at{};
  for (std::size_t i = 0; i < N; ++i) {
    const auto found = find(names, prefix + rest[i]);
    if (!found) return std::nullopt;
    at[i] = *found;
  }
  return at;
}

std::optional<std::size_t> first_of(const Names& names, std::initializer_list<const char*> wanted) {
  for (const char* name : wanted)
    if (const auto at = find(names, name)) return at;
  return std::nullopt;
}

// Tables as this program has them, whatever separates their cells.
bool take_own(const Names& names, TableHeader& header) {
  for (const auto& [unit, scale] : {std::pair{"_mm", 1e-3}, std::pair{"_m", 1.0}}) {
    const std::string u = unit;
    const std::string x = "x" + u, y = "y" + u, z = "z" + u;
    for (const char* prefix : {"", "marker_"})
      if (const auto at =
              find_all<7>(names, prefix, {x.c_str(), y.c_str(), z.c_str(), "qw", "qx", "qy", "qz"})) {
        BodyColumns body;
        body.at = *at;
        body.metres_per_unit = scale;
        header.bodies.push_back(body);
        header.own = true;
        header.form = "a table of poses";
        header.told = "x y z in " + u.substr(1);
        return true;
      }
    if (const auto at = find_all<3>(names, "", {x.c_str(), y.c_str(), z.c_str()})) {
      header.points =
          PointColumns{*at, first_of(names, {"label", "name", "landmark", "point", "corner", "id"}), scale};
      header.own = true;
      header.form = "a table of points";
      header.told = u.substr(1);
      return true;
    }
  }
  return false;
}

// "/topic/pose/position/x", ".pose.pose.position.x", "field.pose.position.x" and "pose_position_x" are one to us.
std::string dotted(std::string_view name) {
  std::string result = lower_case(name);
  std::replace(result.begin(), result.end(), '/', '.');
  std::replace(result.begin(), result.end(), '_', '.');
  while (result.starts_with('.') || result.starts_with('%')) result.erase(0, 1);
  return result;
}

struct RosNames {
  const char *place, *turn;
};

bool take_ros(const Names& plain, TableHeader& header) {
  Names names;
  for (const auto& name : plain) names.push_back(dotted(name));
  for (const RosNames form : {RosNames{"position", "orientation"}, RosNames{"translation", "rotation"}}) {
    const std::string x = std::string(form.place) + ".x", y = std::string(form.place) + ".y",
                      z = std::string(form.place) + ".z", t = std::string(form.turn) + ".";
    for (const auto& name : names) {
      if (!name.ends_with(x)) continue;
      const auto prefix = name.substr(0, name.size() - x.size());
      const auto at = find_all<7>(names, prefix,
                                  {x.c_str(), y.c_str(), z.c_str(), (t + "w").c_str(), (t + "x").c_str(),
                                   (t + "y").c_str(), (t + "z").c_str()});
      if (!at) continue;
      BodyColumns body;
      body.name = prefix.empty() ? form.place : prefix.substr(0, prefix.size() - 1);
      body.at = *at;
      body.metres_per_unit = 1.0;
      header.bodies.push_back(body);
    }
  }
  if (header.bodies.empty()) return false;
  header.form = "a table of ROS";
  header.told = "x y z in m";
  // A message's own stamp where it has one, else when the recorder had it.
  const auto with_end = [&](std::string_view end) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == end || names[i].ends_with("." + std::string(end))) return i;
    return std::nullopt;
  };
  for (const auto& [s, ns] : {std::pair{"header.stamp.secs", "header.stamp.nsecs"},
                              std::pair{"header.stamp.sec", "header.stamp.nanosec"}})
    if (const auto at = with_end(s), rest = with_end(ns); at && rest) {
      header.time = {TimeForm::seconds_and_nanoseconds, {*at, *rest}};
      return true;
    }
  if (const auto at = find(plain, "__time"))  // PlotJuggler's
    header.time = {TimeForm::seconds, {*at}};
  else if (const auto stamp = with_end("header.stamp"))
    header.time = {TimeForm::nanoseconds, {*stamp}};
  else if (const auto other = first_of(names, {"time", "rosbagtimestamp", "timestamp", "stamp"}))
    header.time = {TimeForm::nanoseconds, {*other}};
  return true;
}

// "p_RS_R_x [m]", "q_RS_w []" of EuRoC (Burri and others, IJRR 2016): the body's pose in the reference frame.
bool take_euroc(const Names& names, TableHeader& header) {
  std::array<std::optional<std::size_t>, 7> at;
  const std::string letters = "xyzwxyz";
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto name = std::string(trimmed(names[i].substr(0, names[i].find('['))));
    for (std::size_t k = 0; k < at.size(); ++k)
      if (name.starts_with(k < 3 ? "p_" : "q_") && name.ends_with(std::string("_") + letters[k]) && !at[k]) {
        at[k] = i;
        break;
      }
  }
  if (!std::all_of(at.begin(), at.end(), [](const auto& one) { return one.has_value(); })) return false;
  BodyColumns body;
  for (std::size_t k = 0; k < at.size(); ++k) body.at[k] = *at[k];
  body.metres_per_unit = 1.0;
  header.bodies.push_back(body);
  header.form = "a trajectory of EuRoC";
  header.told = "the body in the reference frame, ns and m";
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].starts_with("timestamp")) header.time = {TimeForm::nanoseconds, {i}};
  return true;
}

// Names of NDI's columns that are no tool's.
bool is_word_of_ndi(const std::string& name) {
  constexpr std::array kWords = {"frame",           "frame#",   "face",     "face#",    "state",
                                 "transformstatus", "error",    "markers",  "#markers", "tools",
                                 "#tools",          "toolinfo", "wav time", "time",     "portstatus",
                                 "porthandle"};
  return std::find(kWords.begin(), kWords.end(), name) != kWords.end();
}

// Blocks of columns side by side, one for each tool: its name, Frame, State, Q0 Qx Qy Qz Tx Ty Tz (or Rz Ry Rx Tx Ty Tz).
bool take_ndi(const std::vector<std::string_view>& written, const Names& names, TableHeader& header) {
  std::size_t begin = 0;  // of the block
  for (std::size_t i = 0; i + 6 <= names.size(); ++i) {
    const bool turned = i + 7 <= names.size() && names[i] == "q0" && names[i + 1] == "qx" &&
                        names[i + 2] == "qy" && names[i + 3] == "qz" && names[i + 4] == "tx" &&
                        names[i + 5] == "ty" && names[i + 6] == "tz";
    const bool angles = names[i] == "rz" && names[i + 1] == "ry" && names[i + 2] == "rx" &&
                        names[i + 3] == "tx" && names[i + 4] == "ty" && names[i + 5] == "tz";
    if (!turned && !angles) continue;
    BodyColumns body;
    const std::size_t t = i + (turned ? 4 : 3);
    body.at = {t, t + 1, t + 2, i, i + 1, i + 2, turned ? i + 3 : i};
    body.euler_degrees = angles;
    body.metres_per_unit = 1e-3;
    for (std::size_t k = begin; k < i; ++k) {
      if (names[k] == "state" || names[k] == "transformstatus") body.state = k;
      if (!names[k].empty() && !is_word_of_ndi(names[k])) body.name = trimmed(written[k]);
    }
    header.bodies.push_back(body);
    begin = t + 3;
    i = t + 2;
  }
  if (header.bodies.empty()) return false;
  header.form = "an export of NDI's programs";
  header.told = "Q0 Qx Qy Qz Tx Ty Tz, mm";
  if (const auto at = first_of(names, {"wav time", "time", "time_s", "timestamp"}))
    header.time = {TimeForm::seconds, {*at}};
  return true;
}

// x y z and a quaternion in seven columns, their names with one ending for each body ("Xa, Ya, Za, qoa, qxa, qya, qza").
bool take_seven(const Names& names, TableHeader& header) {
  bool ndi = false, of_tum = false;
  for (std::size_t i = 0; i + 7 <= names.size(); ++i) {
    if (!names[i].starts_with("x") && !names[i].starts_with("tx")) continue;
    const std::string t = names[i].starts_with("t") ? "t" : "";
    const auto ending = names[i].substr(t.size() + 1);
    if (names[i + 1] != t + "y" + ending || names[i + 2] != t + "z" + ending) continue;
    const auto is = [&](std::size_t k, std::string_view name) {
      return names[i + k] == std::string(name) + ending;
    };
    BodyColumns body;
    body.at = {i, i + 1, i + 2, i + 3, i + 4, i + 5, i + 6};
    if ((is(3, "qo") || is(3, "q0") || is(3, "qw")) && is(4, "qx") && is(5, "qy") && is(6, "qz")) {
      ndi |= is(3, "qo");
    } else if (is(3, "qx") && is(4, "qy") && is(5, "qz") && is(6, "qw")) {
      body.at = {i, i + 1, i + 2, i + 6, i + 3, i + 4, i + 5};
      of_tum |= t == "t" && ending.empty();
    } else {
      continue;
    }
    body.name = ending;
    header.bodies.push_back(body);
    i += 6;
  }
  if (header.bodies.empty()) return false;
  header.form = ndi ? "an export of NDI's combined API" : of_tum ? kTum : "a table of poses without a unit";
  header.told = ndi      ? "x y z and qo qx qy qz, mm"
                : of_tum ? "tx ty tz qx qy qz qw, s and m"
                         : "x y z and a quaternion";
  for (auto& body : header.bodies) body.metres_per_unit = ndi ? 1e-3 : of_tum ? 1.0 : 0.0;
  if (const auto day = find_all<4>(names, "", {"hour", "minutes", "seconds", "ms"}))
    header.time = {TimeForm::time_of_day, *day};
  return true;
}

// A place in three columns and, right behind it, a quaternion x y z w that is called nothing else: "pos_x, pos_y, pos_z, x, y, z,
// w", and "position, x, y, z, orientation, x, y, z, w" of bags that were taken apart.
bool take_place_and_turn(const Names& names, TableHeader& header) {
  const auto are = [&](std::size_t at, std::initializer_list<const char*> wanted) {
    std::size_t i = at;
    for (const char* name : wanted)
      if (i >= names.size() || names[i++] != name) return false;
    return true;
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    BodyColumns body;
    const bool plain = are(i, {"pos_x", "pos_y", "pos_z", "x", "y", "z", "w"});
    if (plain)
      body.at = {i, i + 1, i + 2, i + 6, i + 3, i + 4, i + 5};
    else if (are(i, {"position", "x", "y", "z", "orientation", "x", "y", "z", "w"}))
      body.at = {i + 1, i + 2, i + 3, i + 8, i + 5, i + 6, i + 7};
    else
      continue;
    body.metres_per_unit = plain ? 0.0 : 1.0;
    header.bodies.push_back(body);
    header.form = plain ? "a table of poses without a unit" : "a table of ROS";
    header.told = plain ? "x y z and a quaternion" : "x y z in m";
    const auto s = find(names, "secs"), ns = find(names, "nsecs");
    if (!plain && s && ns) header.time = {TimeForm::seconds_and_nanoseconds, {*s, *ns}};
    return true;
  }
  return false;
}

// "x,y,z" alone: points in nobody knows what.
bool take_points(const Names& names, TableHeader& header) {
  const auto at = find_all<3>(names, "", {"x", "y", "z"});
  if (!at) return false;
  const auto again = std::count(names.begin(), names.end(), "x") > 1;
  if (again || first_of(names, {"w", "qw", "q_w"})) {
    header.cannot = again ? "names x, y and z more than once; which are the place is not known"
                          : "names x, y, z and a w: a quaternion, beside which the place is not known";
    return true;
  }
  header.points = PointColumns{*at, first_of(names, {"label", "name", "landmark", "point", "id"}), 0.0};
  header.form = "a table of points without a unit";
  header.told = "x y z";
  return true;
}

// "timestamp [ns]", "time (seconds)", "t_s", "stamp": what it is called without its unit, and the unit. Nothing where it is no time.
std::optional<TimeForm> time_form(std::string name) {
  std::string unit;
  if (const auto open = name.find_first_of("[("); open != std::string::npos) {
    unit = trimmed(std::string_view(name).substr(open + 1));
    while (!unit.empty() && (unit.back() == ']' || unit.back() == ')')) unit.pop_back();
    name = trimmed(std::string_view(name).substr(0, open));
  } else if (const auto under = name.rfind('_'); under != std::string::npos && name.size() - under <= 5) {
    unit = name.substr(under + 1);
    name = name.substr(0, under);
  }
  constexpr std::array kTimes = {"time", "timestamp", "t", "stamp", "ts"};
  constexpr std::array kSeconds = {"sec", "secs", "seconds"};
  const auto is_one_of = [](const auto& words, const std::string& word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  if (unit.empty() && is_one_of(kSeconds, name)) return TimeForm::seconds;
  if (!is_one_of(kTimes, name)) return std::nullopt;
  if (unit.empty() || unit == "s" || is_one_of(kSeconds, unit)) return TimeForm::seconds;
  if (unit == "ms") return TimeForm::milliseconds;
  if (unit == "us") return TimeForm::microseconds;
  if (unit == "ns" || unit == "nsec") return TimeForm::nanoseconds;
  return std::nullopt;
}

// Seconds before the others, as a table may have both.
void find_time(const Names& names, TableHeader& header) {
  if (header.time.form != TimeForm::none) return;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto form = time_form(names[i]);
    if (!form || (header.time.form != TimeForm::none && *form != TimeForm::seconds)) continue;
    header.time = {*form, {i}};
    if (*form == TimeForm::seconds) return;
  }
}

// Places that are turned, too, in columns that are not read, are no points: who converts them loses how they are turned.
void refuse_turned_points(const std::vector<std::string_view>& written, TableHeader& header) {
  const auto turn = device::turn_columns(Names(written.begin(), written.end()));
  if (turn.empty()) return;
  header.cannot = fmt::format("has places, and {} which {} not read", turn,
                              turn.find(',') == std::string::npos ? "is" : "are");
}

}  // namespace

std::optional<TableHeader> understand_header(const std::vector<std::string_view>& written) {
  Names names;
  for (auto name : written) {
    name = trimmed(name);
    while (name.starts_with('#') && !name.starts_with("#Tools")) name = trimmed(name.substr(1));
    names.push_back(lower_case(name));
  }
  TableHeader header;
  const bool known = take_own(names, header) || take_ros(names, header) || take_euroc(names, header) ||
                     take_ndi(written, names, header) || take_seven(names, header) ||
                     take_place_and_turn(names, header) || take_points(names, header);
  if (!known) return std::nullopt;
  find_time(names, header);
  if (header.points) refuse_turned_points(written, header);
  // In a trajectory of TUM the column before the place is the time, whatever it is called.
  if (header.form == kTum && header.time.form == TimeForm::none && header.bodies.front().at[0] == 1)
    header.time = {TimeForm::seconds, {0}};
  return header;
}

}  // namespace palpate::formats
