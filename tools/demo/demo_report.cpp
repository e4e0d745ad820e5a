#include "tools/demo/demo_report.h"

#include <algorithm>

#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {
namespace fs = std::filesystem;
namespace {

// Frame pictures shown in the page; more would make it heavy, not clearer.
constexpr std::size_t kMostPictures = 4;

void add_figure(std::vector<figures::Figure>& figures, const figures::PlayFolder& data, std::string_view path,
                std::string label, std::string_view unit, std::optional<double> at_most_this,
                std::string bar) {
  const auto value = data.number(path);
  if (!value) return;
  const figures::Verdict verdict =
      at_most_this ? figures::at_most(*value, *at_most_this) : figures::Verdict::none;
  figures.push_back({std::move(label), figures::shown(value, unit), std::move(bar), verdict});
}

// The picture a film shows before it plays: a hit, where there is one.
std::string poster_of(const figures::PlayFolder& data) {
  if (data.has("poster.png")) return "poster.png";
  const auto pictures = data.pictures("pictures");
  for (const auto& name : pictures)
    if (name.find("-hit") != std::string::npos || name.find("-touch") != std::string::npos) return name;
  return pictures.empty() ? "poster.png" : pictures.front();
}

}  // namespace

void add_what_you_see_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  page.section("What you see", "see");
  const std::string there =
      touches(data)
          ? "The table is real; what lies on it exists only in the computer. The hand feels its surface "
            "through the stylus: how it is shaped, how far it gives way, how it holds and slips. "
          : "Table and wall are real; ball and bat exist only in the computer. The bat rides on the "
            "stylus, the ball bounces off the real table and the real wall, and each hit is felt in the "
            "hand. ";
  const bool two_eyes = data.find("registration/right_eye") != nullptr;
  const std::string view =
      std::string("The player's view") +
      (two_eyes ? ", left eye and right eye side by side: each camera's picture" : ": the camera's picture") +
      ", undistorted, with " + (touches(data) ? "surface and stylus" : "ball and bat") + " drawn into it.";
  page.paragraph(
      std::string("A person holds the stylus of a haptic arm and looks at the scene through ") +
      (two_eyes ? "two cameras worn on the head, one for each eye. " : "a camera worn on the head. ") +
      there +
      "In this run every device is simulated: arm, optical tracker, camera, clocks, hand and player. That is "
      "what "
      "lets every error below be measured against the truth, which the program itself never gets to see.");
  if (data.has("video.mp4")) {
    page.video(data.bytes("video.mp4"), data.bytes(poster_of(data)), view);
  } else if (data.has("poster.png")) {
    page.picture(data.bytes("poster.png"), view);
  }
  std::vector<std::pair<std::string, std::string>> pictures;
  std::vector<std::string> names = data.pictures("pictures");
  // The one from the side is always among them, the last.
  const auto outside = std::stable_partition(names.begin(), names.end(),
                                             [](const auto& name) { return name != "pictures/outside.png"; });
  const auto seen = static_cast<std::size_t>(outside - names.begin());
  if (seen < names.size() && seen >= kMostPictures) names.erase(names.begin() + kMostPictures - 1, outside);
  for (const auto& name : names) {
    if (pictures.size() == kMostPictures) break;
    const std::string file = fs::path(name).filename().string();
    pictures.emplace_back(data.bytes(name), data.text("pictures/" + file).value_or(file));
  }
  if (!pictures.empty()) page.pictures(pictures);
  std::vector<figures::Figure> figures;
  const auto bar = arm_bar_mm(data);
  add_figure(figures, data, "arm/error_to_truth_mean_mm", "Arm: the tip's error against the truth", "mm", bar,
             fmt::format("at most {}, half of the best of the paper's methods or 0.3 mm",
                         figures::shown(bar, "mm")));
  add_figure(figures, data, "registration/world_px_rms", "Overlay on the real scene, rms", "px", 0.3,
             "at most 0.3 px");
  add_figure(figures, data, "registration/tip_px_rms", "Overlay on the stylus tip, rms", "px", 0.6,
             "at most 0.6 px");
  const auto serves = data.number("rally/serves"), returned = data.number("rally/returned");
  if (serves && returned && *serves > 0) {
    figures.push_back(
        {"Serves returned", fmt::format("{:.0f} of {:.0f}", *returned, *serves),
         *serves < kEnoughServes ? "too few for a verdict" : "at least 60 %",
         *serves < kEnoughServes ? figures::Verdict::none : figures::at_least(*returned, 0.6 * *serves)});
  }
  if (const auto share = data.number("touch/contact_s"), of = data.number("touch/of_s"); share && of)
    figures.push_back({"On the surface", figures::shown(share, "s"),
                       fmt::format("of {}", figures::shown(of, "s")), figures::Verdict::none});
  add_figure(figures, data, "force/peak_n",
             touches(data) ? "Strongest force the hand felt" : "Strongest blow the hand felt", "N", 8.5,
             "at most 8.5 N, the arm's limit");
  add_figure(figures, data, "realtime/exchange/round_trip_us/median",
             "Asking for the state, round trip, median", "\u00b5s", std::nullopt,
             "real time, between two processes");
  page.figures(figures);
}

Expected<evaluation::report::Report> demo_report(const fs::path& folder) {
  const auto data = figures::PlayFolder::read(folder);
  if (!data) return tl::unexpected(data.error());
  const bool touch = touches(*data);
  std::string subtitle =
      std::string("A report of one demonstration of Palpate on the simulated rig: calibrate ") +
      "everything, " + (touch ? "explore a surface" : "play ping-pong") +
      ", and hold each figure against the truth.";
  if (const auto seed = data->number("seed")) subtitle += fmt::format(" Seed {:.0f}.", *seed);
  evaluation::report::Report page(
      touch ? "Palpate: a surface you can see and feel" : "Palpate: ping-pong you can see and feel",
      subtitle);
  add_what_you_see_section(page, *data);
  add_arm_section(page, *data);
  add_tip_and_camera_section(page, *data);
  add_overlay_section(page, *data);
  add_exchange_section(page, *data);
  if (touch) {
    add_touch_section(page, *data);
  } else {
    add_forces_section(page, *data);
    add_play_section(page, *data);
  }
  add_real_time_section(page, *data);
  add_network_section(page, *data);
  add_how_section(page, *data);
  return page;
}

Expected<void> write_demo_report(const fs::path& folder) {
  const auto page = demo_report(folder);
  if (!page) return tl::unexpected(page.error());
  return page->write(folder / "report.html");
}

}  // namespace palpate::tools::demo
