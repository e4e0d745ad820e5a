// Pictures into the headset, frame by frame. One thread, whose OpenGL context it uses.
#pragma once

#include <memory>
#include <optional>

#include "palpate/headset/internal/openxr_instance.h"
#include "palpate/headset/internal/openxr_swapchain.h"
#include "palpate/headset/internal/shared_state.h"
#include "palpate/render/context.h"

namespace palpate::headset {

class OpenXrSession {
 public:
  static Expected<std::unique_ptr<OpenXrSession>> open(const OpenXrInstance& instance,
                                                       std::shared_ptr<render::Context> context,
                                                       SharedState& shared);
  ~OpenXrSession();
  OpenXrSession(const OpenXrSession&) = delete;
  OpenXrSession& operator=(const OpenXrSession&) = delete;

  // What the runtime has to say. Fails, with the code `disconnected`, when it ends the session.
  Expected<void> listen();
  // The runtime wants frames.
  bool running() const { return running_; }
  // One frame: waits until the runtime asks for it.
  Expected<void> frame();

 private:
  OpenXrSession(const OpenXrInstance& instance, std::shared_ptr<render::Context> context, SharedState& shared)
      : instance_(instance), context_(std::move(context)), shared_(shared) {}
  Expected<void> make_spaces();
  Expected<void> choose_blend_mode();
  Expected<void> follow(XrSessionState state);
  void local_moved(const XrEventDataReferenceSpaceChangePending& change);
  Pose<Local, Local> first_local_at(XrTime time) const;
  Expected<void> look_at_head(Instant<GraphicsClock> now, XrTime time);
  Expected<void> take_what_is_handed_over(Instant<GraphicsClock> displayed);
  Expected<void> take_picture(std::unique_ptr<HandedPicture> handed, Instant<GraphicsClock> displayed);
  void add_layers(XrTime displayed);
  void count_frame(const DisplayTimes& display);

  const OpenXrInstance& instance_;
  std::shared_ptr<render::Context> context_;
  SharedState& shared_;
  XrSession session_ = XR_NULL_HANDLE;
  XrSpace local_ = XR_NULL_HANDLE, view_ = XR_NULL_HANDLE;
  XrEnvironmentBlendMode blend_ = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  bool running_ = false;

  // LOCAL may be laid anew while we run. Poses are kept in the one of the beginning, to which these lead.
  Pose<Local, Local> X_first_local_;
  struct Change {
    XrTime time = 0;
    Pose<Local, Local> X_before_after;
  };
  std::optional<Change> coming_change_;

  OpenXrSwapchain picture_, panel_;
  double distance_ = 0.0;                          // of the picture that picture_ holds
  std::optional<Pose<Local, View>> X_first_view_;  // the head at its image; none: not known
  bool panel_shown_ = false;
  double panel_wide_ = 0.0;
  Vector3 panel_middle_ = Vector3::Zero();
  std::vector<XrCompositionLayerQuad> layers_;
};

}  // namespace palpate::headset
