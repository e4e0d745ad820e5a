#include "palpate/system/picture_book.h"

#include <fmt/format.h>

#include "palpate/applications/pingpong/pingpong.h"
#include "palpate/applications/touch/touch.h"
#include "palpate/compositor/picture_file.h"
#include "palpate/system/overlay.h"

namespace palpate {
namespace {

constexpr int kPlayPictures = 5, kHitPictures = 3;
constexpr double kAfterHit = 0.25;  // s after a hit in which a picture still shows it
constexpr double kPatienceForBall =
    0.5;  // of the time between two pictures: then one without the ball is taken

}  // namespace

bool ball_in_sight(const FrameRecord& frame, const CameraModel& lens, const SceneDescription& scene) {
  const auto& ball = frame.state.bodies[pingpong::kBall];
  const auto& bat = frame.state.bodies[pingpong::kBat];
  if (!frame.have_state || frame.state.body_count <= pingpong::kBat || ball.visible == 0) return false;
  const auto pixel = drawn_pixel({lens, frame.X_world_camera}, ball.p());
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

// The touched surface's place, or the ball, in sight.
bool PictureBook::in_sight(const FrameRecord& frame) const {
  if (scene_.application != "touch") return ball_in_sight(frame, lens_, scene_);
  if (!frame.have_state || frame.state.body_count <= touch::kProxy) return false;
  const auto pixel = drawn_pixel({lens_, frame.X_world_camera}, frame.state.bodies[touch::kProxy].p());
  return pixel && pixel->x() > 0.0 && pixel->x() < lens_.width && pixel->y() > 0.0 &&
         pixel->y() < lens_.height;
}

PictureBook::PictureBook(std::filesystem::path folder, double seconds, const CameraModel& lens,
                         const SceneDescription& scene)
    : folder_(std::move(folder)), lens_(lens), scene_(scene), every_(seconds / kPlayPictures) {}

Expected<void> PictureBook::look(const FrameRecord& frame) {
  const double now = frame.state.time.seconds();
  if (!started_) next_ = now + every_ / 4;
  started_ = true;
  const bool touches = scene_.application == "touch";
  const auto hits =
      frame.state.counters[touches ? std::size_t{touch::kTouches} : std::size_t{pingpong::kHits}];
  if (hits > hits_ && hit_pictures_ < kHitPictures) hit_until_ = now + kAfterHit;
  hits_ = hits;

  const bool seen = in_sight(frame);
  const bool hit = seen && now <= hit_until_;
  const bool due = now >= next_ + (seen ? 0.0 : kPatienceForBall * every_);
  if (!hit && !due) return {};
  if (due) next_ += every_;
  if (outside_ && (count_ == 0 || (hit && hit_pictures_ == 0)))
    if (auto done = write_outside(frame); !done) return done;
  if (hit) {
    ++hit_pictures_;
    hit_until_ = 0.0;
  }
  const std::string name = fmt::format("{:02d}-{}.png", ++count_, !hit ? "play" : touches ? "touch" : "hit");
  captions_[name] = touches ? hit ? "Just after the tip met the surface" : "While exploring"
                    : hit   ? "Just after the bat met the ball"
                            : "During play";
  return write_png(folder_ / name, frame.rgb, frame.width, frame.height);
}

Expected<void> PictureBook::write_outside(const FrameRecord& frame) {
  const OutsidePicture& seen = outside_(frame);
  if (seen.rgb.empty()) return {};
  captions_["outside.png"] =
      "The same play from the side, drawn from what the system knows: the yellow pyramid is what the "
      "player's "
      "camera sees";
  return write_png(folder_ / "outside.png", seen.rgb, seen.width, seen.height);
}

}  // namespace palpate
