// Cost of one simulated camera picture, in milliseconds of all threads together and as a ratio to an empty
// pass over as many pixels in the same process. Rounds alternate; the empty pass runs twice, the difference
// is the noise. A software renderer's ratio says how much of the work is the shaders' own; it carries over to
// another machine where milliseconds do not.
#include <epoxy/gl.h>
#include <fmt/core.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <vector>

#include "bench/frame_bench.h"
#include "palpate/core/statistics.h"
#include "palpate/render/context.h"
#include "palpate/render/gl_objects.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/simulator.h"

namespace palpate::bench {
namespace {

constexpr int kRounds = 15, kPictures = 8;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Contender {
  const char* name;
  std::function<void(std::size_t picture)> draw;
  std::vector<double> ms;  // per picture, one of each round
};

}  // namespace

int camera_pictures() {
  // Head as in use, and in front of the board: what calibration and play look at.
  sim::Simulator world(sim::config::reference_world(), 3);
  std::vector<sim::TrueView> in_use, with_board;
  for (auto& [gesture, views] :
       {std::pair{device::Gesture::look, &in_use}, {device::Gesture::look_around_board, &with_board}}) {
    if (!world.person().ask({gesture, "", 0})) return 1;
    for (int i = 0; i < kPictures; ++i) {
      world.advance_to(world.now() + seconds(0.35));
      views->push_back(world.true_view());
    }
  }
  sim::CameraRenderer renderer;
  std::vector<std::uint8_t> rgb;
  const device::CameraModel& lens = in_use.front().lens;
  render::FullScreen screen;
  render::Target target(lens.width, lens.height, render::Format::rgb8, false);
  render::Program plain("bench/empty", render::kFullScreen,
                        "out vec4 colour; void main() { colour = vec4(0.5); }");
  const auto empty = [&](std::size_t) {
    target.bind();
    glDisable(GL_BLEND);
    plain.use();
    for (int i = 0; i < 20; ++i) screen.draw();
    glFinish();
  };
  std::vector<Contender> all{
      {"empty pass", empty, {}},
      {"camera picture", [&](std::size_t i) { renderer.render(in_use[i], rgb); }, {}},
      {"with the board", [&](std::size_t i) { renderer.render(with_board[i], rgb); }, {}},
      {"empty pass again", empty, {}}};
  for (int round = -1; round < kRounds; ++round) {  // the first compiles shaders
    for (auto& contender : all) {
      const double begun = cpu_ms();
      for (std::size_t i = 0; i < kPictures; ++i) contender.draw(i);
      if (round >= 0) contender.ms.push_back((cpu_ms() - begun) / kPictures);
    }
  }
  for (auto* of_many : {&all.front(), &all.back()})
    for (double& ms : of_many->ms) ms /= 20;
  fmt::print("{}, {}x{}, median of {} rounds\n", render::Context::required()->renderer(), lens.width,
             lens.height, kRounds);
  for (const auto& contender : all)
    fmt::print("{:18} {:8.2f} CPU ms {:8.1f} empty passes\n", contender.name, median(contender.ms),
               median(contender.ms) / median(all.front().ms));
  return 0;
}

}  // namespace palpate::bench

int main() {
  const int failed = palpate::bench::camera_pictures();
  return failed != 0 ? failed : palpate::bench::augmented_pictures();
}
