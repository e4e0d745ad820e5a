// The graphics side of a session, put together once for every way of running: the devices by their URIs, one camera or
// two, the link to a physics server, what looks at pixels, the graphics server, and the scripted player in front of
// it.
//
// It knows no clock and no thread but the one that made it: who owns it calls service() about every millisecond and
// finish() when it is time to draw.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/desktop/scripted_user.h"
#include "palpate/device/driver_registry.h"
#include "palpate/render/compositor.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/server/graphics/quality_choice.h"
#include "palpate/server/session/graphics_devices.h"
#include "palpate/transport/state_link.h"

namespace palpate::server::session {

class GraphicsSide {
 public:
  // In real time drawing begins when the reply has come, or this long after the image was taken up, whether it has or
  // not: the loop goes on meanwhile, and a frame of 33 ms does not miss it.
  static constexpr Duration kDrawAfter = std::chrono::milliseconds(2);

  // `scene` is what the physics server plays; an application that is not among setup.applications is shown by its
  // bodies alone. `pipeline`: instead of what setup.pixels says; it must outlive the side. Refused where a part
  // cannot be made; throws as GraphicsServer.
  static Expected<std::unique_ptr<GraphicsSide>> make(const GraphicsSetup& setup, GraphicsDevices devices,
                                                      std::unique_ptr<transport::StateLink> link,
                                                      const scene::SceneDescription& scene,
                                                      graphics::FramePipeline* pipeline = nullptr);
  GraphicsSide(const GraphicsSide&) = delete;
  GraphicsSide& operator=(const GraphicsSide&) = delete;

  // Takes what has come from devices and network.
  void service(Instant<GraphicsClock> now) { server_->service(now); }
  // Takes up the newest image where none is being worked on; true when a frame has begun.
  bool begin(Instant<GraphicsClock> now) { return !server_->frame_begun() && server_->begin_frame(now); }
  // The frame that was begun, drawn; valid until the next one. The player sees it where it plays.
  const graphics::FrameRecord& finish(Instant<GraphicsClock> now, bool player_sees = true);
  // To be told of each frame when it has been drawn: where its quality is chosen here and becomes another, why.
  std::optional<std::string> choose_quality(const graphics::FrameRecord& frame, Instant<GraphicsClock> drawn);
  // None: it was chosen beforehand.
  const std::optional<graphics::QualityChoice>& quality() const { return quality_; }
  // The player leads the hand; nothing where there is no player.
  void lead_hand(Instant<GraphicsClock> now);

  graphics::GraphicsServer& server() { return *server_; }
  const graphics::GraphicsServer& server() const { return *server_; }
  const GraphicsDevices& devices() const { return devices_; }
  transport::StateLink& link() { return *link_; }
  const transport::StateLink& link() const { return *link_; }
  const scene::SceneDescription& scene() const { return scene_; }
  graphics::FrameRenderer* renderer() { return renderer_ ? &*renderer_ : nullptr; }  // null: nothing is drawn
  desktop::ScriptedUser* player() { return player_ ? &*player_ : nullptr; }          // null: there is none

 private:
  GraphicsSide(GraphicsDevices devices, std::unique_ptr<transport::StateLink> link,
               scene::SceneDescription scene)
      : devices_(std::move(devices)), link_(std::move(link)), scene_(std::move(scene)) {}
  Expected<void> make_renderer(const GraphicsSetup& setup);
  void make_server(const GraphicsSetup& setup, graphics::FramePipeline& pipeline);

  GraphicsDevices devices_;
  std::unique_ptr<transport::StateLink> link_;
  scene::SceneDescription scene_;
  std::optional<graphics::FrameRenderer> renderer_;
  std::optional<graphics::QualityChoice> quality_;
  graphics::NullFramePipeline blind_;
  std::optional<graphics::GraphicsServer> server_;
  std::optional<desktop::ScriptedUser> player_;
};

}  // namespace palpate::server::session
