// A headset of any OpenXR runtime, which shows what it is told: the client of tests/program/monado_test.py. A camera of
// its own stands before each eye.
//
// Commands on standard input, a line each; each is answered by a line of JSON on standard output:
//   dots     a red, a green and a blue dot at working distance, as the head now sees them
//   greys    patches of 0 to 255, red, green and blue in different orders
//   level N  nothing but that grey
//   facts    nothing new
// The answers: facts of the headset, when the picture is seen for the first time, and in `places` of `dots` and `greys`,
// for each eye, where each dot or patch stands, in OpenXR's VIEW of the moment of the command.
#include <fmt/format.h>

#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>

#include "palpate/core/json.h"
#include "palpate/headset/dots_for_tests.h"

namespace palpate::headset {
namespace {

constexpr double kDistance = 0.6;  // m
constexpr int kPatches = 16;       // across, and down
constexpr auto kPatience = std::chrono::seconds(60);

// As cameras are mounted: before the eyes, a little above them, turned a little.
Eye mounted_camera(double sideways) {
  Eye eye;
  eye.X_view_camera.translation = Vector3(sideways, 0.02, -0.06);
  eye.X_view_camera.rotation = so3_exp(Vector3(-0.05, 0.03, 0.02)) * eye.X_view_camera.rotation;
  return eye;
}

class Shower {
 public:
  Shower() {
    settings_.eyes = {mounted_camera(-0.032), mounted_camera(0.032)};
    auto opened = Headset::open(settings_);
    if (!opened) throw std::runtime_error(opened.error().message);
    headset_ = std::move(*opened);
  }

  Json obey(const std::string& command) {
    if (command == "dots") return show_dots();
    if (command == "greys") return show_greys();
    if (command.rfind("level ", 0) == 0) {
      const auto level = static_cast<std::uint8_t>(std::stoi(command.substr(6)));
      return show(std::vector<std::uint8_t>(bytes(), level));
    }
    if (command == "facts") return facts();
    throw std::runtime_error("unknown: " + command);
  }

 private:
  const device::CameraModel& camera() const { return settings_.eyes.front().camera; }
  int width() const { return 2 * camera().width; }
  std::size_t bytes() const {
    return 3 * static_cast<std::size_t>(width()) * static_cast<std::size_t>(camera().height);
  }
  Instant<GraphicsClock> now() const { return settings_.clock.from_monotonic(settings_.monotonic_ns()); }

  Json facts() const {
    const HeadsetFacts facts = headset_->facts();
    return {{"device", facts.device},     {"runtime", facts.runtime},
            {"frames", facts.frames},     {"with_picture", facts.with_picture},
            {"pictures", facts.pictures}, {"unplaced", facts.unplaced},
            {"now_ns", now().ns()},       {"period_ns", facts.display.period.count()}};
  }

  template <typename Condition>
  void wait_until(Condition condition, const char* what) const {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > until) throw std::runtime_error(what);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  Json show(const std::vector<std::uint8_t>& rgb) {
    wait_until([&] { return headset_->head_at(now()).usable(); }, "the runtime tells no pose of the head");
    headset_->show({rgb, width(), camera().height, now(), kDistance});
    ++shown_;
    wait_until(
        [&] {
          const auto shown = headset_->shown();
          return shown && shown->picture == shown_;
        },
        "the runtime takes up no picture");
    Json answer = facts();
    answer["displayed_ns"] = headset_->shown()->displayed.ns();
    return answer;
  }

  Json show_dots() {
    // Places in View, for a head at Local's origin.
    const Pose<Local, View> here;
    const Pose<Local, CameraOptical> X = here * settings_.eyes.front().X_view_camera;
    const Dots dots{X * Point<CameraOptical>{{0.02, 0.01, kDistance}},
                    X * Point<CameraOptical>{{0.12, 0.06, kDistance}},
                    X * Point<CameraOptical>{{-0.11, -0.07, kDistance}}};
    Json answer = show(picture_of(dots, settings_.eyes, here));
    Json places = Json::array();
    for (const auto& dot : dots) places.push_back({dot.m.x(), dot.m.y(), dot.m.z()});
    answer["places"] = {places, places};
    return answer;
  }

  Json show_greys() {
    std::vector<std::uint8_t> rgb(bytes());
    const int across = camera().width / kPatches, down = camera().height / kPatches;
    std::size_t at = 0;
    for (int v = 0; v < camera().height; ++v)
      for (int u = 0; u < width(); ++u, at += 3) {
        const int level = kPatches * (v / down) + u % camera().width / across;
        rgb[at] = static_cast<std::uint8_t>(level);
        rgb[at + 1] = static_cast<std::uint8_t>(255 - level);
        rgb[at + 2] = static_cast<std::uint8_t>(level ^ 0x55);
      }
    Json answer = show(rgb);
    for (const Eye& eye : settings_.eyes) {
      Json places = Json::array();
      for (int level = 0; level < kPatches * kPatches; ++level) {
        const double u = (level % kPatches + 0.5) * across - 0.5, v = (level / kPatches + 0.5) * down - 0.5;
        const Vector3 ray((u - camera().cx) / camera().fx, (v - camera().cy) / camera().fy, 1.0);
        const Vector3 place = (eye.X_view_camera * Point<CameraOptical>{kDistance * ray}).m;
        places.push_back({place.x(), place.y(), place.z()});
      }
      answer["places"].push_back(places);
    }
    return answer;
  }

  HeadsetSettings settings_;
  std::unique_ptr<Headset> headset_;
  std::uint64_t shown_ = 0;
};

}  // namespace
}  // namespace palpate::headset

int main() {
  try {
    palpate::headset::Shower shower;
    for (std::string command; std::getline(std::cin, command);)
      std::cout << shower.obey(command).dump() << std::endl;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
  return 0;
}
