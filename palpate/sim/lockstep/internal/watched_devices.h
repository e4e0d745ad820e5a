// The simulator's devices as a play in lock-step has them: looked at beside the truth, and disturbed on their way.
//
// One thread; the simulator must outlive them.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "palpate/device/devices.h"
#include "palpate/evaluation/played_frame.h"
#include "palpate/sim/simulated_display.h"
#include "palpate/sim/simulator.h"

namespace palpate::sim::lockstep {

// The world's camera, which keeps what it saw of the truth beside each image, and passes the view on to
// whoever draws it.
class WatchedCamera : public device::CameraDevice {
 public:
  WatchedCamera(Simulator& world, RenderView render) : world_(world), render_(std::move(render)) {
    world_.set_renderer([this](const TrueView& view, std::vector<std::uint8_t>& rgb) {
      views_.push_back(view);
      if (closed_)
        rgb.assign(3 * static_cast<std::size_t>(view.lens.width) * static_cast<std::size_t>(view.lens.height),
                   0);
      else if (render_)
        render_(view, rgb);
    });
  }
  ~WatchedCamera() override { world_.set_renderer(render_); }
  // While closed its images are black: nothing is drawn that nobody looks at.
  void close(bool closed) { closed_ = closed; }
  void disturb(std::function<void(std::optional<device::CameraImage>&)> how) { disturb_ = std::move(how); }
  // What hangs in its view; an image that nobody draws is grey otherwise.
  void see(SimulatedDisplay* display) { display_ = display; }

  std::optional<device::CameraImage> poll() override {
    views_.clear();
    auto image = world_.camera().poll();
    if (image && !views_.empty()) {
      // A picture is made of one view or of several; the middle one is mid-exposure.
      const auto& view = views_[views_.size() / 2];
      seen_.push_back({image->frame, {view.lens, view.X_world_camera}, true_tip(view)});
      if (seen_.size() > kKept) seen_.pop_front();
      if (display_ != nullptr && !closed_) {
        if (image->rgb.empty())
          image->rgb.assign(
              3 * static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height), kGrey);
        display_->paint(*image, view, world_.camera_clock().true_time(image->mid_exposure));
      }
    }
    if (disturb_) disturb_(image);
    return image;
  }

  // What was true when the image of this number was taken; it may have been held back since.
  bool truth_of(std::uint64_t frame, evaluation::PlayedFrame& played) const {
    for (const auto& seen : seen_) {
      if (seen.frame != frame) continue;
      played.truth = seen.truth;
      played.true_tip = seen.true_tip;
      return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kKept = 64;
  static constexpr std::uint8_t kGrey = 110;
  struct Seen {
    std::uint64_t frame = 0;
    evaluation::CameraView truth;
    Vector3 true_tip = Vector3::Zero();
  };
  Simulator& world_;
  RenderView render_;
  std::vector<TrueView> views_;
  std::deque<Seen> seen_;
  std::function<void(std::optional<device::CameraImage>&)> disturb_;
  SimulatedDisplay* display_ = nullptr;
  bool closed_ = false;
};

template <typename Device>
class Disturbed : public Device {
 public:
  using Polled = decltype(std::declval<Device&>().poll());
  Disturbed(Device& device, std::function<void(Polled&)> how) : device_(device), how_(std::move(how)) {}
  Polled poll() override {
    Polled polled = device_.poll();
    if (how_) how_(polled);
    return polled;
  }

 private:
  Device& device_;
  std::function<void(Polled&)> how_;
};

}  // namespace palpate::sim::lockstep
