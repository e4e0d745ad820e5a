// A person with a headset in front of the graphics server's picture: frames go into it as they are drawn, score and
// warnings stand before both eyes.
//
// What the runtime does (goes, hangs, returns) is told to the log of the part "graphics", each once. Thread: the frame
// loop's; nothing waits for the runtime (palpate/headset/headset.h).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "palpate/core/json.h"
#include "palpate/desktop/headset_log.h"
#include "palpate/desktop/hud.h"
#include "palpate/desktop/working_distance.h"
#include "palpate/headset/headset.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/frame_record.h"
#include "palpate/server/graphics/graphics_figures.h"

namespace palpate::desktop {

struct HeadsetViewOptions {
  std::optional<double> distance;  // m; none: that of the stylus' tip
  MonotonicClock<GraphicsClock> clock;
  std::filesystem::path out{};  // folder for what a calibration needs (headset_log.h); empty: none
};

class HeadsetView {
 public:
  // Refused as Headset::open, and where the rig's cameras are not calibrated.
  static Expected<std::unique_ptr<HeadsetView>> open(const rig::Rig& rig,
                                                     const scene::SceneDescription& scene,
                                                     const HeadsetViewOptions& options);
  // On a headset that is open already.
  static std::unique_ptr<HeadsetView> on(std::unique_ptr<headset::Headset> headset,
                                         std::unique_ptr<Lettering> lettering,
                                         const scene::SceneDescription& scene,
                                         const HeadsetViewOptions& options);

  // A frame has been drawn. Without a pose of the camera, or a picture, nothing new is shown.
  void show(const server::graphics::FrameRecord& frame, Instant<GraphicsClock> now);
  // Every millisecond or so: score and warnings of `content`, and how the runtime is.
  void act(const HudContent& content, Instant<GraphicsClock> now);
  // To who wears it, for some seconds: what has changed by itself.
  void say(std::string words, Instant<GraphicsClock> now);

  // When a picture that is finished then will be seen.
  Instant<GraphicsClock> display_time(Instant<GraphicsClock> finished) const {
    return headset_->display_time(finished);
  }
  // Why the person sees nothing new; none: all is well.
  const std::optional<std::string>& trouble() const { return trouble_; }
  const headset::Headset& headset() const { return *headset_; }

  Json figures() const;
  // Puts its files in place, at the end.
  Expected<void> finish() { return log_ ? log_->finish() : Expected<void>{}; }

 private:
  HeadsetView(std::unique_ptr<headset::Headset> headset, std::unique_ptr<Lettering> lettering,
              const scene::SceneDescription& scene, const HeadsetViewOptions& options)
      : headset_(std::move(headset)), hud_(std::move(lettering)), scene_(scene), options_(options) {}
  void put_words(const HudContent& content, Instant<GraphicsClock> now);
  void follow_runtime(Instant<GraphicsClock> now);

  std::unique_ptr<headset::Headset> headset_;
  Hud hud_;
  scene::SceneDescription scene_;
  HeadsetViewOptions options_;
  WorkingDistance distance_;
  std::optional<HeadsetLog> log_;
  std::optional<std::string> trouble_;
  std::uint64_t words_version_ = 0;
  std::string said_;
  Instant<GraphicsClock> said_at_;
  std::optional<Instant<GraphicsClock>> asked_;
  std::uint64_t seen_ = 0;                 // the picture whose display was counted last
  server::graphics::Quantiles age_;        // of pictures when they are seen first, since mid-exposure
  server::graphics::Quantiles hand_over_;  // what show() takes
};

// The panels of a head-up display that matter to who wears a headset, one below the other; empty: nothing is said.
// `said`: instead of the hint, which is for who sits at keys; empty: nothing.
Canvas stacked_words(Hud& hud, const HudContent& content, const std::string& said, std::uint64_t* version);

}  // namespace palpate::desktop
