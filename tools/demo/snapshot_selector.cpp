#include "tools/demo/snapshot_selector.h"

#include <fmt/format.h>

#include <cctype>

#include "applications/pingpong/pingpong.h"
#include "applications/touch/touch.h"
#include "palpate/evaluation/overlay.h"
#include "palpate/render/picture_file.h"

namespace palpate::tools::demo {
namespace {

constexpr int kPlayPictures = 5, kHitPictures = 3;
constexpr double kAfterHit = 0.25;  // s after a hit in which a picture still shows it
constexpr double kPatienceForBall =
    0.5;  // of the time between two pictures: then one without the ball is taken

}  // namespace

bool ball_in_sight(const server::graphics::FrameRecord& frame, const device::CameraModel& lens,
                   const scene::SceneDescription& scene) {
  const auto& ball = frame.state.bodies[applications::pingpong::kBall];
  const auto& bat = frame.state.bodies[applications::pingpong::kBat];
  if (!frame.have_state || frame.state.body_count <= applications::pingpong::kBat || ball.visible == 0)
    return false;
  const auto pixel = evaluation::drawn_pixel({lens, frame.X_world_camera}, ball.p());
  if (!pixel || pixel->x() < 0.0 || pixel->x() > lens.width || pixel->y() < 0.0 || pixel->y() > lens.height)
    return false;
  if (bat.visible == 0) return true;
  // Where the line from eye to ball goes through the bat's plane.
  const Vector3 eye = frame.X_world_camera.translation, sight = ball.p() - eye;
  const Vector3 normal = bat.q() * Vector3::UnitY();
  const double along = normal.dot(bat.p() - eye) / normal.dot(sight);
  if (!(along > 0.0 && along < 1.0)) return true;
  return (eye + along * sight - bat.p()).norm() > scene.bat_radius;
}

std::string what_is_seen(const server::graphics::FrameRecord& frame, const scene::SceneDescription& scene,
                         bool hit, bool seen) {
  const auto& counters = frame.state.counters;
  if (scene.application == "touch") {
    if (hit) return "the tip has just met the surface";
    const bool touching = counters[applications::touch::kForceMn] > 0;
    const std::string tip = !touching                                     ? "the tip above the surface"
                            : counters[applications::touch::kSliding] > 0 ? "the tip slides over the surface"
                                                                          : "the tip holds on the surface";
    return seen ? tip : tip + ", out of the picture";
  }
  if (hit) return "the bat has just met the ball";
  std::string ball;
  switch (static_cast<applications::pingpong::Phase>(counters[applications::pingpong::kPhase])) {
    case applications::pingpong::Phase::waiting:
      return "between two balls";
    case applications::pingpong::Phase::ready:
      ball = fmt::format("ball {} waits to be served", counters[applications::pingpong::kServes] + 1);
      break;
    case applications::pingpong::Phase::incoming:
      ball = counters[applications::pingpong::kRally] == 0
                 ? fmt::format("serve {} on its way to the player", counters[applications::pingpong::kServes])
                 : "the ball comes back from the wall";
      break;
    case applications::pingpong::Phase::outgoing:
      ball = "the ball on its way to the wall";
      break;
  }
  return seen ? ball : ball + ", hidden by the bat or out of the picture";
}

// The touched surface's place, or the ball, in sight.
bool SnapshotSelector::in_sight(const server::graphics::FrameRecord& frame) const {
  if (scene_.application != "touch") return ball_in_sight(frame, lens_, scene_);
  if (!frame.have_state || frame.state.body_count <= applications::touch::kProxy) return false;
  const auto pixel = evaluation::drawn_pixel({lens_, frame.X_world_camera},
                                             frame.state.bodies[applications::touch::kProxy].p());
  return pixel && pixel->x() > 0.0 && pixel->x() < lens_.width && pixel->y() > 0.0 &&
         pixel->y() < lens_.height;
}

SnapshotSelector::SnapshotSelector(std::filesystem::path folder, double seconds,
                                   const device::CameraModel& lens, const scene::SceneDescription& scene)
    : folder_(std::move(folder)), lens_(lens), scene_(scene), every_(seconds / kPlayPictures) {}

Expected<void> SnapshotSelector::look(const server::graphics::FrameRecord& frame) {
  const double now = frame.state.time.seconds();
  if (!started_) begun_ = now, next_ = now + every_ / 4;
  started_ = true;
  const bool touches = scene_.application == "touch";
  const auto hits = frame.state.counters[touches ? std::size_t{applications::touch::kTouches}
                                                 : std::size_t{applications::pingpong::kHits}];
  if (hits > hits_ && hit_pictures_ < kHitPictures) hit_until_ = now + kAfterHit;
  hits_ = hits;

  const bool seen = in_sight(frame);
  const bool hit = seen && now <= hit_until_;
  const bool due = now >= next_ + (seen ? 0.0 : kPatienceForBall * every_);
  if (!hit && !due) return {};
  if (due) next_ += every_;
  if (outside_ && (count_ == 0 || (hit && hit_pictures_ == 0)))
    if (auto done = write_outside(frame, hit); !done) return done;
  if (hit) {
    ++hit_pictures_;
    hit_until_ = 0.0;
  }
  const std::string name = fmt::format("{:02d}-{}.png", ++count_, !hit ? "play" : touches ? "touch" : "hit");
  std::string caption = what_is_seen(frame, scene_, hit, seen) + moment(frame);
  caption.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(caption.front())));
  captions_[name] = caption;
  return render::write_png(folder_ / name, frame.rgb, frame.width, frame.height);
}

std::string SnapshotSelector::moment(const server::graphics::FrameRecord& frame) const {
  return fmt::format(", {:.1f} s into the play", frame.state.time.seconds() - begun_);
}

Expected<void> SnapshotSelector::write_outside(const server::graphics::FrameRecord& frame, bool hit) {
  const render::OutsidePicture& seen = outside_(frame);
  if (seen.rgb.empty()) return {};
  captions_["outside.png"] =
      fmt::format("The same play from the side, drawn from what the system knows: {}{}. {}",
                  what_is_seen(frame, scene_, hit, /*seen=*/true), moment(frame),
                  frame.two_eyes ? "The yellow pyramids are what the player's two cameras see"
                                 : "The yellow pyramid is what the player's camera sees");
  return render::write_png(folder_ / "outside.png", seen.rgb, seen.width, seen.height);
}

}  // namespace palpate::tools::demo
