#include "tools/demo/demo_report.h"

#include <algorithm>
#include <array>

#include "palpate/core/toml.h"
#include "palpate/figures/limits.h"
#include "tools/demo/raw_files.h"
#include "tools/demo/report_data.h"

namespace palpate::tools::demo {
namespace fs = std::filesystem;
namespace {

using evaluation::report::PageTemplates, figures::PlayFolder;

constexpr const char* kOutside = "pictures/outside.png";

// Of the player's own view, in the order of time.
std::vector<std::string> seen_pictures(const PlayFolder& play) {
  std::vector<std::string> names = play.pictures("pictures");
  std::erase(names, kOutside);
  return names;
}

// "03-hit.png" does, "02-play.png" does not.
bool shows_event(const std::string& name) {
  return name.find('-') != std::string::npos && name.find("-play") == std::string::npos;
}

// The picture a film shows before it plays: the last event (a hit, a touch) that there is one of. Before the first ones
// nothing has been scored or felt yet.
Json poster_of(const PlayFolder& play) {
  if (play.has("poster.png")) return "poster.png";
  if (!play.has("video.mp4")) return nullptr;
  const auto names = seen_pictures(play);
  const auto event = std::find_if(names.rbegin(), names.rend(), shows_event);
  if (event != names.rend()) return *event;
  return names.empty() ? Json() : Json(names.back());
}

// Width over height as a PNG's first chunk states them; of what is no PNG, a camera's 4 : 3.
double shape_of(std::string_view png) {
  constexpr std::size_t kSizes = 16;  // signature, and the chunk's length and name
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(png[at + i]);
    return static_cast<double>(value);
  };
  if (png.size() < kSizes + 8 || png.substr(1, 3) != "PNG" || png.substr(12, 4) != "IHDR") return 4.0 / 3.0;
  const double width = number(kSizes), height = number(kSizes + 4);
  return width > 0.0 && height > 0.0 ? width / height : 4.0 / 3.0;
}

// Two in a row: the last event that the film does not show already, then the last of the others, then the one from the
// side.
Json pictures_of(const PlayFolder& play, const Json& poster) {
  constexpr std::size_t kMost = 4;  // more would make the page heavy, not clearer
  std::vector<std::string> names = seen_pictures(play);
  if (poster.is_string()) std::erase(names, poster.get<std::string>());
  const auto event = std::find_if(names.rbegin(), names.rend(), shows_event);
  if (event != names.rend()) std::rotate(names.begin(), event.base() - 1, event.base());
  const bool outside = play.has(kOutside);
  const std::size_t most = outside ? kMost - 1 : kMost, first = event != names.rend() ? 1 : 0;
  if (names.size() > most)
    names.erase(names.begin() + static_cast<std::ptrdiff_t>(first),
                names.end() - static_cast<std::ptrdiff_t>(most - first));
  if (outside) names.emplace_back(kOutside);
  Json rows = Json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string file = fs::path(names[i]).filename().string();
    if (i % 2 == 0) rows.push_back(Json::array());
    rows.back().push_back({{"file", names[i]},
                           {"caption", play.text("pictures/" + file).value_or(file)},
                           {"shape", shape_of(play.bytes(names[i]))}});
  }
  return rows;
}

std::string stem(std::string_view file) { return std::string(file.substr(0, file.rfind('.'))); }

// How many rows each table of raw/ has, under its name without .csv.
Json rows_of(const PlayFolder& play) {
  Json rows = Json::object();
  for (const auto& [name, table] : play.tables())
    if (!table.rows.empty()) rows[stem(name)] = table.rows.size();
  return rows;
}

// The application's words: those of its report, else those of NAME.toml, else none.
Expected<Json> words_of(const std::string& name, const scene::PlayReport& report, std::string_view toml) {
  const auto file = parse_toml(toml, name + ".toml");
  if (!file) return tl::unexpected(file.error());
  Json words{{"name", name}};
  const std::array<std::pair<const char*, const std::string*>, 5> kWords{
      {{"title", &report.title},
       {"task", &report.task},
       {"scene", &report.scene},
       {"drawn", &report.drawn},
       {"force_label", &report.force_label}}};
  for (const auto& [key, own] : kWords) words[key] = file->text_or(key, *own);
  if (const auto done = file->finish(); !done) return tl::unexpected(done.error());
  return words;
}

Expected<Json> application_of(const PlayFolder& play, const scene::ApplicationSpec* spec,
                              const PageTemplates& templates) {
  const std::string name = play.text("application").value_or("");
  const scene::PlayReport report = spec != nullptr && spec->report ? spec->report(play) : scene::PlayReport{};
  auto application = words_of(name, report, templates.text(name + ".toml"));
  if (!application) return application;
  (*application)["figures"] = evaluation::report::json_of(report.figures);
  (*application)["sections"] = evaluation::report::json_of(report.sections);
  (*application)["data"] = report.data;
  (*application)["tables"] = Json::array();
  if (spec != nullptr)
    for (const auto& table : spec->tables)
      if (const CsvTable* rows = play.raw(table.file))
        (*application)["tables"].push_back(
            {{"file", table.file}, {"rows", rows->rows.size()}, {"holds", table.holds}});
  return application;
}

Expected<Json> judged_of(const PlayFolder& play, const std::string& application,
                         const PageTemplates& templates) {
  auto all = figures::judged(play.summary(), templates.text("limits.toml"), "limits.toml");
  if (!all) return all;
  const std::string own_file = application + "-limits.toml";
  auto own = figures::judged(play.summary(), templates.text(own_file), own_file);
  if (!own) return own;
  all->update(*own);
  return all;
}

// Differences, sums and alternatives that a template cannot form.
Json sums_of(const PlayFolder& play) {
  Json sums = Json::object();
  if (const auto all = play.number("force/limited_ticks"), at_peak = play.number("force/peak_limited_ticks");
      all && at_peak)
    sums["force_held_back_ticks"] = *all - *at_peak;
  if (const auto begun = play.number("realtime/haptic/ticks"), missed = play.number("realtime/haptic/missed");
      begun && missed)
    sums["haptic_due_ticks"] = *begun + *missed;
  const auto known = [&](const char* path) { return play.number(path).has_value(); };
  sums["smaller_calibrations"] = known("pivot/error_to_truth_mm") || known("hand_eye/error_to_truth_mm") ||
                                 known("hand_eye/rotation_error_deg") || known("camera/rms_px");
  sums["overlay"] = known("registration/world_px_rms") || known("registration/tip_px_rms");
  return sums;
}

// registration/disparity has a key for the points of the real scene, and one for a virtual body, named after it.
Json disparities_of(const PlayFolder& play) {
  constexpr std::string_view kRms = "_px_rms";
  Json list = Json::array();
  const Json* disparity = play.find("registration/disparity");
  if (disparity == nullptr || !disparity->is_object()) return list;
  for (const auto& [key, value] : disparity->items())
    if (key.ends_with(kRms) && !key.starts_with("world") && value.is_number())
      list.push_back({{"body", key.substr(0, key.size() - kRms.size())}, {"px", value}});
  return list;
}

// Of what is judged: how many hold, and each that does not, for those who read no further.
Json verdicts_of(const Json& judged, const Json& disparities) {
  Json verdicts{{"holding", 0}, {"short", Json::array()}};
  const auto count = [&](const Json& one) {
    if (one.value("verdict", Json()) == "holds") verdicts["holding"] = verdicts["holding"].get<int>() + 1;
    if (one.value("verdict", Json()) == "falls short") verdicts["short"].push_back(one);
  };
  for (const auto& [name, one] : judged.items()) count(one);
  for (auto one : disparities) {
    one["label"] = fmt::format("{}, {}", one["label"].get<std::string>(), one["body"].get<std::string>());
    one["figure"] = fmt::format("registration/disparity/{}_px_rms", one["body"].get<std::string>());
    count(one);
  }
  verdicts["some_fall_short"] = !verdicts["short"].empty();
  verdicts["all_hold"] = verdicts["short"].empty() && verdicts["holding"] != 0;
  verdicts["of_machine"] = std::ranges::any_of(verdicts["short"], [](const Json& one) {
    return one["figure"].get<std::string>().starts_with("realtime/");
  });
  for (auto& one : verdicts["short"])
    one["words"] = one["value"].is_null()
                       ? fmt::format("{} is missing", one["label"].get<std::string>())
                       : fmt::format("{}: {:.4g}{} ({} {:.4g} is wanted)", one["label"].get<std::string>(),
                                     one["value"].get<double>(),
                                     one["unit"] == "" ? "" : " " + one["unit"].get<std::string>(),
                                     one["bound"].get<std::string>(), one["limit"].get<double>());
  return verdicts;
}

}  // namespace

Expected<Json> demo_report(const fs::path& folder, const scene::ApplicationRegistry& applications,
                           PageTemplates& templates) {
  const auto play = PlayFolder::read(folder);
  if (!play) return tl::unexpected(play.error());
  const std::string name = play->text("application").value_or("");
  const auto* spec = applications.find(name);
  if (spec != nullptr) templates.add_missing(spec->page);
  for (const char* part : {"figures", "sections"})
    templates.use(fmt::format("{}-{}.html", name, part), fmt::format("application-{}.html", part));
  const auto application = application_of(*play, spec, templates);
  if (!application) return application;
  auto judged = judged_of(*play, name, templates);
  if (!judged) return judged;
  // Each body's disparity is judged by the same limit.
  Json disparities = disparities_of(*play);
  for (auto& one : disparities) {
    const auto verdict = figures::judged(one, templates.text("limits.toml"), "limits.toml");
    if (!verdict) return verdict;
    one.update(verdict->value("disparity", Json::object()));
  }
  const Json poster = poster_of(*play);
  Json files = files_of(*play, spec), sums = sums_of(*play);
  sums["files"] = !files.empty();
  Json data = calibration_data(*play);
  data.update(play_data(*play));
  data.update(realtime_data(*play));
  return Json{{"format", 1},
              {"kind", "demo"},
              {"summary", play->summary()},
              {"judged", *judged},
              {"verdicts", verdicts_of(*judged, disparities)},
              {"sums", sums},
              {"disparities", disparities},
              {"application", *application},
              {"video", play->has("video.mp4") ? Json("video.mp4") : Json()},
              {"poster", poster},
              {"pictures", pictures_of(*play, poster)},
              {"data", data},
              {"network", network_data(*play)},
              {"files", files},
              {"beside", files_beside(*play)},
              {"rows", rows_of(*play)}};
}

Expected<Json> write_demo_report(const fs::path& folder, const scene::ApplicationRegistry& applications,
                                 PageTemplates templates) {
  const auto report = demo_report(folder, applications, templates);
  if (!report) return tl::unexpected(report.error());
  if (auto done = evaluation::report::write_report(*report, templates, folder); !done)
    return tl::unexpected(done.error());
  return report;
}

}  // namespace palpate::tools::demo
