#include "tools/demo/snapshot_selector.h"

#include <fmt/format.h>

#include <cctype>

#include "palpate/render/picture_file.h"

namespace palpate::tools::demo {
namespace {

constexpr int kPlayPictures = 5, kEventPictures = 3;
constexpr double kAfterEvent = 0.25;  // s after a hit in which a picture still shows it
constexpr double kPatience =
    0.5;  // of the time between two pictures: then one without what the play is about is taken

}  // namespace

SnapshotSelector::SnapshotSelector(std::filesystem::path folder, double seconds,
                                   const device::CameraModel& lens, const scene::PlayRecord& record)
    : folder_(std::move(folder)), lens_(lens), record_(record), every_(seconds / kPlayPictures) {}

Expected<void> SnapshotSelector::look(const server::graphics::FrameRecord& frame) {
  const double now = frame.state.time.seconds();
  if (!started_) begun_ = now, next_ = now + every_ / 4;
  started_ = true;
  const scene::Highlight shown = record_.highlight({.state = frame.state,
                                                    .have_state = frame.have_state,
                                                    .lens = lens_,
                                                    .X_world_camera = frame.X_world_camera});
  if (shown.events > events_ && event_pictures_ < kEventPictures) event_until_ = now + kAfterEvent;
  events_ = shown.events;

  const bool event = shown.in_sight && now <= event_until_;
  const bool due = now >= next_ + (shown.in_sight ? 0.0 : kPatience * every_);
  if (!event && !due) return {};
  if (due) next_ += every_;
  if (outside_ && (count_ == 0 || (event && event_pictures_ == 0)))
    if (auto done = write_outside(frame, event ? shown.just_after : shown.going_on); !done) return done;
  if (event) {
    ++event_pictures_;
    event_until_ = 0.0;
  }
  const std::string name = fmt::format("{:02d}-{}.png", ++count_, event ? shown.event : "play");
  std::string caption = (event            ? shown.just_after
                         : shown.in_sight ? shown.going_on
                                          : shown.unseen) +
                        moment(frame);
  caption.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(caption.front())));
  captions_[name] = caption;
  return render::write_png(folder_ / name, frame.rgb, frame.width, frame.height);
}

std::string SnapshotSelector::moment(const server::graphics::FrameRecord& frame) const {
  return fmt::format(", {:.1f} s into the play", frame.state.time.seconds() - begun_);
}

Expected<void> SnapshotSelector::write_outside(const server::graphics::FrameRecord& frame,
                                               const std::string& what) {
  const render::OutsidePicture& seen = outside_(frame);
  if (seen.rgb.empty()) return {};
  captions_["outside.png"] = fmt::format(
      "The same play from the side, drawn from what the system knows: {}{}. {}", what, moment(frame),
      frame.two_eyes ? "The yellow pyramids are what the player's two cameras see"
                     : "The yellow pyramid is what the player's camera sees");
  return render::write_png(folder_ / "outside.png", seen.rgb, seen.width, seen.height);
}

}  // namespace palpate::tools::demo
