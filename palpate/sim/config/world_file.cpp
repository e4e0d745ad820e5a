#include "palpate/sim/config/world_file.h"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <type_traits>

#include "palpate/core/file.h"
#include "palpate/core/toml.h"
#include "palpate/core/units.h"
#include "palpate/rig/file_mixup.h"
#include "palpate/scene/settings_file.h"
#include "palpate/sim/config/internal/world_fields.h"
#include "palpate/sim/config/reference_world_text.h"

namespace palpate::sim::config {
namespace {

// Overwrites what the file gives and leaves the rest.
class Reader {
 public:
  Reader(TomlTable root, scene::SettingValues& settings) : root_(root), table_(root), settings_(settings) {}
  static bool takes(bool) { return true; }
  void section(std::string_view name) {
    end_section();
    section_ = name;
    table_ = root_.table(name);
  }
  // An application's keys in this section.
  void end_section() {
    if (section_.empty()) return;
    for (const auto& setting : settings_.all())
      if (setting.field.section == section_ && asked_.contains(setting.field.key))
        table_.complain(setting.field.key,
                        "is the laboratory's, and an application of this program claims it, too");
    scene::read_settings(table_, section_, settings_);
    asked_.clear();
    section_.clear();
  }
  void sections_of_applications() {
    for (const auto& name : scene::sections_of(settings_))
      if (!is_laboratorys(name)) scene::read_settings(root_.table(name), name, settings_);
  }
  TomlTable section_table(std::string_view name) { return root_.table(name); }

  void number(std::string_view key, double& field, double unit, NumberRange range) {
    if (given(key)) field = table_.number(key, range) * unit;
  }
  void integer(std::string_view key, int& field, NumberRange range) {
    if (given(key)) field = static_cast<int>(table_.integer(key, range));
  }
  template <std::size_t N>
  void numbers(std::string_view key, std::array<double, N>& field, double unit, NumberRange range) {
    if (!given(key)) return;
    field = table_.numbers<N>(key, range);
    for (auto& x : field) x *= unit;
  }
  void integers(std::string_view key, std::array<int, 2>& field, NumberRange range) {
    if (!given(key)) return;
    const auto list = table_.numbers<2>(key, range);
    for (std::size_t i = 0; i < 2; ++i) {
      if (list[i] != std::floor(list[i])) table_.complain(key, "whole numbers are wanted");
      field[i] = static_cast<int>(list[i]);
    }
  }
  void vector(std::string_view key, Vector3& field, double unit) {
    if (!given(key)) return;
    const auto list = table_.numbers<3>(key);
    field = Vector3(list[0], list[1], list[2]) * unit;
  }
  template <typename Rows>
  void rows(std::string_view key, Rows& field, double unit) {
    if (!given(key)) return;
    std::size_t count = 0;
    if constexpr (!std::is_same_v<Rows, std::vector<Vector3>>) count = field.size();
    const auto list = table_.rows(key, 3, count);
    if constexpr (std::is_same_v<Rows, std::vector<Vector3>>) field.assign(list.size(), Vector3::Zero());
    for (std::size_t i = 0; i < list.size() && i < field.size(); ++i)
      field[i] = Vector3(list[i][0], list[i][1], list[i][2]) * unit;
  }
  void ranges(std::string_view key, std::array<Range, 3>& field, double unit, NumberRange range) {
    if (!given(key)) return;
    const auto list = table_.rows(key, 2, field.size(), range);
    for (std::size_t i = 0; i < list.size() && i < field.size(); ++i) {
      field[i] = {list[i][0] * unit, list[i][1] * unit};
      if (!(list[i][0] < list[i][1])) table_.complain(key, "each range must be [low, high] with low < high");
    }
  }
  void choice(std::string_view key, std::string& field, const std::vector<std::string>& allowed) {
    if (given(key)) field = table_.choice(key, allowed);
  }
  void text(std::string_view key, std::string& field) {
    if (given(key)) field = table_.text(key);
  }
  void clock(std::string_view key, ClockSettings& field) {
    if (!given(key)) return;
    const auto clock = table_.table(key);
    field.offset_s = clock.number_or("offset_s", 0.0, {-1e6, 1e6});
    field.drift = clock.number_or("drift_ppm", 0.0, {-1e5, 1e5}) * 1e-6;
  }
  void pose(std::string_view key, Vector3& translation, Vector3& rotation) {
    if (!given(key)) return;
    const auto place = table_.table(key);
    const auto t = place.numbers<3>("translation_m");
    const auto r = place.numbers<3>("rotation_deg");
    translation = Vector3(t[0], t[1], t[2]);
    rotation = Vector3(r[0], r[1], r[2]) * kDeg;
  }

 private:
  bool given(std::string_view key) {
    asked_.emplace(key);
    table_.expect(key);
    return table_.has(key);
  }
  TomlTable root_, table_;
  scene::SettingValues& settings_;
  std::string section_;
  std::set<std::string, std::less<>> asked_;  // of this section
};

class Writer {
 public:
  explicit Writer(const scene::SettingValues& settings) : settings_(settings) {}
  static bool takes(bool there) { return there; }
  void section(std::string_view name) {
    end_section();
    section_ = name;
    out_ += (out_.empty() ? "[" : "\n[") + section_ + "]\n";
  }
  void end_section() {
    out_ += scene::settings_text(settings_, section_);
    section_.clear();
  }
  void sections_of_applications() {
    for (const auto& name : scene::sections_of(settings_))
      if (!is_laboratorys(name)) section(name);
  }
  void number(std::string_view key, double field, double unit, NumberRange) { line(key, text(field, unit)); }
  void integer(std::string_view key, int field, NumberRange) { line(key, std::to_string(field)); }
  template <std::size_t N>
  void numbers(std::string_view key, const std::array<double, N>& field, double unit, NumberRange) {
    line(key, list(field, unit));
  }
  void integers(std::string_view key, const std::array<int, 2>& field, NumberRange) {
    line(key, fmt::format("[{}, {}]", field[0], field[1]));
  }
  void vector(std::string_view key, const Vector3& field, double unit) { line(key, list(field, unit)); }
  template <typename Rows>
  void rows(std::string_view key, const Rows& field, double unit) {
    std::string all;
    for (const auto& row : field) all += (all.empty() ? "" : ", ") + list(row, unit);
    line(key, "[" + all + "]");
  }
  void ranges(std::string_view key, const std::array<Range, 3>& field, double unit, NumberRange) {
    rows(key, field, unit);
  }
  void choice(std::string_view key, const std::string& field, const std::vector<std::string>&) {
    line(key, toml_quoted(field));
  }
  void text(std::string_view key, const std::string& field) { line(key, toml_quoted(field)); }
  void clock(std::string_view key, const ClockSettings& field) {
    line(key, fmt::format("{{ offset_s = {}, drift_ppm = {} }}", text(field.offset_s, 1.0),
                          text(field.drift, 1e-6)));
  }
  void pose(std::string_view key, const Vector3& translation, const Vector3& rotation) {
    line(key, fmt::format("{{ translation_m = {}, rotation_deg = {} }}", list(translation, 1.0),
                          list(rotation, kDeg)));
  }
  const std::string& content() const { return out_; }

 private:
  // The shortest decimal that reads back to this field, so that 0.165 mm is not written as
  // 0.16500000000000001.
  static std::string text(double field, double unit) {
    for (int digits = 1; digits <= 17; ++digits) {
      const std::string short_text = fmt::format("{:.{}g}", field / unit, digits);
      // Not std::stod, which throws at numbers too small for all their digits.
      const double value = std::strtod(short_text.c_str(), nullptr);
      if (value * unit == field) return toml_number(value);
    }
    return toml_number(field / unit);
  }
  template <typename List>
  static std::string list(const List& values, double unit) {
    std::string all;
    for (const double value : values) all += (all.empty() ? "" : ", ") + text(value, unit);
    return "[" + all + "]";
  }
  void line(std::string_view key, const std::string& value) { out_ += fmt::format("{} = {}\n", key, value); }
  const scene::SettingValues& settings_;
  std::string section_, out_;
};

bool is_rectangle_like(const Corners& c) {
  return (c[1] - c[0]).cross(c[3] - c[0]).norm() > 1e-6 && (c[2] - c[1]).norm() > 1e-3 &&
         (c[3] - c[2]).norm() > 1e-3;
}

double spread(const std::vector<Vector3>& leds) {  // area of the largest triangle, m^2
  double area = 0.0;
  for (std::size_t i = 0; i < leds.size(); ++i)
    for (std::size_t j = i + 1; j < leds.size(); ++j)
      for (std::size_t k = j + 1; k < leds.size(); ++k)
        area = std::max(area, 0.5 * (leds[j] - leds[i]).cross(leds[k] - leds[i]).norm());
  return area;
}

void check_faults(Reader& reader, const WorldFile& w) {
  for (const auto& [key, span] : {std::pair{"camera_silent_s", &w.faults.camera_silent},
                                  {"image_size_s", &w.faults.image_size},
                                  {"camera_clock_s", &w.faults.camera_clock},
                                  {"tracker_silent_s", &w.faults.tracker_silent},
                                  {"tracker_blind_s", &w.faults.tracker_blind},
                                  {"tracker_clock_s", &w.faults.tracker_clock}}) {
    if ((*span)[0] > (*span)[1])
      reader.section_table("faults").complain(key, "[from, until] with from <= until");
    if (w.faults.repeat_s > 0.0 && (*span)[1] > w.faults.repeat_s)
      reader.section_table("faults").complain(
          key, fmt::format("ends at {} s, after it is to begin anew; until repeat_s = {} at most is expected",
                           (*span)[1], w.faults.repeat_s));
  }
}

// What no single number shows: things that cannot be built.
void check_whole(Reader& reader, const WorldFile& w) {
  const auto leds = [&](const char* section, const std::vector<Vector3>& body) {
    if (body.size() < 3 || spread(body) < 1e-6)
      reader.section_table(section).complain("leds_mm",
                                             "a body needs three or more LEDs that are not in one line");
  };
  leds("tip_marker", w.tip_marker.leds);
  leds("camera_marker", w.camera_marker.leds);
  leds("pointer", w.pointer.leds);
  for (const auto& camera : w.tracker.cameras)
    if ((w.tracker.look_at - camera).norm() < 1e-3)
      reader.section_table("tracker").complain("look_at_m",
                                               "the cameras must stand away from the point they look at");
  if ((w.tracker.cameras[2] - w.tracker.cameras[0]).cross(w.tracker.look_at - w.tracker.cameras[0]).norm() <
      1e-3)
    reader.section_table("tracker").complain("camera_positions_m",
                                             "the outer cameras need a base line across the view");
  if (!is_rectangle_like(w.scene.table))
    reader.section_table("scene").complain("table_corners_m",
                                           "four corners of a rectangle, in order, are expected");
  if (!is_rectangle_like(w.scene.wall))
    reader.section_table("scene").complain("wall_corners_m",
                                           "four corners of a rectangle, in order, are expected");
  if ((w.head.look_at - w.head.eye).norm() < 1e-3)
    reader.section_table("head").complain("look_at_m", "must lie away from eye_m");
  if (w.hand.pull[0] > w.hand.pull[1])
    reader.section_table("hand").complain("pull_n", "[low, high] with low <= high");
  check_faults(reader, w);
  if (const auto& joints = w.arm_faults.exchanged_joints;
      (joints[0] == joints[1]) != (joints[0] == 0) || (joints[0] == 0) != (joints[1] == 0))
    reader.section_table("arm_faults")
        .complain("exchanged_joints", "two different joints, or [0, 0], are expected");
  if (w.camera.exposure_s * w.camera.rate_hz > 1.0)
    reader.section_table("camera").complain(
        "exposure_ms",
        "is longer than the time between two pictures (1 / rate_hz); at most that is expected");
  if (w.camera.blur_steps % 2 == 0)
    reader.section_table("camera").complain("blur_steps", "must be odd, so that one of them is mid-exposure");
  if (w.scene.landmarks_moved > w.scene.landmarks)
    reader.section_table("scene").complain("landmarks_moved", "is more than there are landmarks");
  if (w.camera.shutter == "rolling" && w.camera.readout_s <= 0.0)
    reader.section_table("camera").complain("shutter", "a rolling shutter needs readout_ms > 0");
}

// What the reference names is no mistake, even where no application here has it.
void expect_what_the_reference_names(const TomlTable& root) {
  static const auto names = [] {
    std::map<std::string, std::vector<std::string>> found;
    const TomlTable reference = *parse_toml(kReferenceWorldText, "reference.toml");
    for (const auto& section : reference.keys()) found[section] = reference.table(section).keys();
    return found;
  }();
  for (const auto& [section, keys] : names) {
    if (!root.has(section)) continue;
    const TomlTable table = root.table(section);
    for (const auto& key : keys) table.expect(key);
  }
}

Expected<WorldFile> parse_over(WorldFile world, std::string_view content, const std::string& source,
                               const scene::ApplicationRegistry& applications) {
  const auto root = parse_toml(content, source);
  if (!root) return tl::unexpected(root.error());
  if (auto fine = rig::is_no_rig_file(*root, source); !fine) return tl::unexpected(fine.error());
  Reader reader(*root, world.settings);
  visit(reader, world);
  expect_what_the_reference_names(*root);
  if (const auto done = root->finish(); !done) return tl::unexpected(done.error());
  check_whole(reader, world);
  scene::complain_of_relations(*root, applications, world.settings);
  if (const auto done = root->finish(); !done) return tl::unexpected(done.error());
  return world;
}

Expected<WorldFile> reference_of(const scene::ApplicationRegistry& applications) {
  WorldFile blank;
  blank.settings = applications.settings();
  return parse_over(std::move(blank), kReferenceWorldText, "reference.toml", applications);
}

}  // namespace

std::string_view reference_world_text() { return kReferenceWorldText; }

const WorldFile& reference_world() {
  static const WorldFile world = reference_world(scene::ApplicationRegistry());
  return world;
}

WorldFile reference_world(const scene::ApplicationRegistry& applications) {
  auto parsed = reference_of(applications);
  if (!parsed) throw std::logic_error("the compiled-in reference world: " + parsed.error().message);
  return std::move(*parsed);
}

Expected<WorldFile> parse_world(std::string_view content, const std::string& source,
                                const scene::ApplicationRegistry& applications) {
  auto reference = reference_of(applications);
  if (!reference) return reference;
  return parse_over(std::move(*reference), content, source, applications);
}

Expected<WorldFile> read_world(const std::filesystem::path& path,
                               const scene::ApplicationRegistry& applications) {
  const auto content = read_file(path, kMostSettingsBytes);
  if (!content) return tl::unexpected(content.error());
  auto world = parse_world(*content, path.string(), applications);
  if (world) scene::resolve_files(path.parent_path(), world->settings);
  return world;
}

std::string world_text(const WorldFile& world) {
  Writer writer(world.settings);
  visit(writer, world);
  return writer.content();
}

}  // namespace palpate::sim::config
