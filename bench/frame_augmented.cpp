// One augmented picture, in milliseconds of the wall clock and as a ratio to OpenCV's remap of the same image
// with the same lens in the same rounds. Remap runs twice, the difference is the noise. Then each stage's
// share, with the card made to finish after each: what a stage hands on to the next is then counted where it
// arose, and the sum is a little more than the whole.
#include <epoxy/gl.h>
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "applications/pingpong/scene_view.h"
#include "applications/pingpong/settings.h"
#include "bench/frame_bench.h"
#include "palpate/render/compositor.h"
#include "palpate/render/context.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/simulator.h"

namespace palpate::bench {
namespace {

constexpr int kRounds = 31, kPicturesPerRound = 4, kStagePictures = 20;
constexpr double kEyes = 0.064;  // m apart

double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

double middle(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// The laboratory with head, arm, ball and bat where they are in play.
struct Scene {
  explicit Scene(const sim::TrueView& view) {
    applications::pingpong::describe(scene::SettingValues(applications::pingpong::setting_schema()),
                                     description);
    real.surfaces = {{"table", view.table}, {"wall", view.wall}};
    real.marker_leds = view.marker_leds;
    real.arm =
        render::ArmConfiguration{view.X_world_base, view.lengths, view.theta, view.gimbal, view.X_tip_marker};
    const Pose<World, Tip> tip{view.X_world_base.rotation,
                               (view.X_world_base * device::phantom_tip(view.theta, view.lengths)).m};
    scene::SceneState state;
    state.body_count = 2;
    state.bodies[1].set_q(tip.rotation);
    state.bodies[1].set_p((tip * Point<Tip>{description.carried_offset}).m);
    state.bodies[0].set_p(tip.translation + Vector3(-0.06, 0.03, -0.25));
    scene_view.emplace(description);
    items = scene_view->draw(state);
  }
  scene::SceneDescription description;
  render::RealScene real;
  std::optional<applications::pingpong::PingPongView> scene_view;
  std::vector<scene::DrawItem> items;
};

struct Rival {
  Rival(const device::CameraModel& lens) {
    const cv::Matx33d k(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
    const auto& d = lens.distortion;
    cv::initUndistortRectifyMap(k, cv::Vec<double, 5>(d[0], d[1], d[2], d[3], d[4]), cv::noArray(), k,
                                {lens.width, lens.height}, CV_16SC2, map_1, map_2);
  }
  void draw(device::CameraImage& image) {
    const cv::Mat from(image.height, image.width, CV_8UC3, image.rgb.data());
    cv::remap(from, to, map_1, map_2, cv::INTER_LINEAR);
  }
  cv::Mat map_1, map_2, to;
};

void size(const sim::Simulator& world, int width, int height) {
  sim::TrueView left = world.true_view();
  const double scale = static_cast<double>(height) / left.lens.height;
  device::CameraModel lens = left.lens;
  lens.cx = scale * (lens.cx + 0.5 - 0.5 * lens.width) + 0.5 * width - 0.5;
  lens.cy = scale * (lens.cy + 0.5) - 0.5;
  lens.fx *= scale, lens.fy *= scale;
  lens.width = width, lens.height = height;
  left.lens = lens;
  sim::TrueView right = left;
  right.X_world_camera.translation += left.X_world_camera.rotation * Vector3(kEyes, 0, 0);
  sim::CameraRenderer camera;
  std::vector<device::CameraImage> images(2);
  for (std::size_t i = 0; i < 2; ++i) {
    images[i].width = width, images[i].height = height;
    camera.render(i == 0 ? left : right, images[i].rgb);
  }
  const std::vector<render::Viewpoint> eyes{{&images[0], lens, left.X_world_camera},
                                            {&images[1], lens, right.X_world_camera}};
  const Scene scene(left);
  Rival rival(lens);
  std::vector<std::uint8_t> rgb;

  struct Contender {
    std::string name;
    std::function<void()> draw;
    std::vector<double> ms{};
  };
  std::vector<Contender> all{{"cv::remap", [&] { rival.draw(images[0]); }}};
  std::vector<std::unique_ptr<render::Compositor>> compositors;
  for (const auto& [word, quality] :
       {std::pair{"low", render::Quality::low}, {"medium", render::Quality::medium}}) {
    compositors.push_back(std::make_unique<render::Compositor>(render::settings_of(quality)));
    for (const std::size_t count : {1u, 2u})
      all.push_back({fmt::format("{}, {}", count == 1 ? "mono" : "stereo", word),
                     [&, count, compositor = compositors.back().get()] {
                       compositor->draw(std::span(eyes).first(count), scene.items, scene.real, rgb);
                     }});
  }
  all.push_back({"cv::remap again", all.front().draw});
  std::map<std::string, std::vector<double>> ratios;
  for (int round = -1; round < kRounds; ++round) {  // the first compiles shaders
    for (auto& contender : all) {
      const double begun = wall_ms();
      for (int i = 0; i < kPicturesPerRound; ++i) contender.draw();
      const double ms = (wall_ms() - begun) / kPicturesPerRound;
      if (round < 0) continue;
      contender.ms.push_back(ms);
      ratios[contender.name].push_back(ms / all.front().ms.back());
    }
  }
  fmt::print("\n{}x{}, {} threads of OpenCV, median of {} rounds\n", width, height, cv::getNumThreads(),
             kRounds);
  for (const auto& contender : all)
    fmt::print("{:16} {:7.2f} ms {:6.1f} remaps\n", contender.name, middle(contender.ms),
               middle(ratios[contender.name]));

  for (std::size_t which = 0; which < compositors.size(); ++which) {
    std::map<std::string, double> shares;
    double last = 0.0, sum = 0.0;
    compositors[which]->watch_stages([&](const char* stage) {
      const double now = wall_ms();
      shares[stage] += now - last;
      sum += now - last;
      last = now;
    });
    for (int i = 0; i < kStagePictures; ++i) {
      last = wall_ms();
      compositors[which]->draw(std::span(eyes).first(1), scene.items, scene.real, rgb);
    }
    fmt::print("stages, mono, {}:", which == 0 ? "low" : "medium");
    for (const char* stage : {"shadows", "upload", "background", "layer", "over", "read"})
      fmt::print("  {} {:.2f} ms ({:.0f} %)", stage, shares[stage] / kStagePictures,
                 100.0 * shares[stage] / sum);
    fmt::print("\n");
    compositors[which]->watch_stages({});
  }
}

}  // namespace

int augmented_pictures() {
  sim::Simulator world(sim::config::reference_world(), 3);
  if (!world.person().ask({device::Gesture::look, "", 0})) return 1;
  world.advance_to(world.now() + seconds(1.0));
  size(world, 640, 480);
  size(world, 1280, 720);
  return 0;
}

}  // namespace palpate::bench
