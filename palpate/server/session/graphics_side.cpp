#include "palpate/server/session/graphics_side.h"

#include "palpate/render/context.h"
#include "palpate/scene/generic_view.h"

namespace palpate::server::session {

Expected<std::unique_ptr<GraphicsSide>> GraphicsSide::make(const GraphicsSetup& setup,
                                                           GraphicsDevices devices,
                                                           std::unique_ptr<transport::StateLink> link,
                                                           const scene::SceneDescription& scene,
                                                           graphics::FramePipeline* pipeline) {
  std::unique_ptr<GraphicsSide> side(new GraphicsSide(std::move(devices), std::move(link), scene));
  if (pipeline == nullptr && setup.pixels == Pixels::drawn) {
    if (auto made = side->make_renderer(setup); !made) return tl::unexpected(made.error());
    pipeline = &*side->renderer_;
  }
  side->make_server(setup, pipeline != nullptr ? *pipeline : side->blind_);
  if (!setup.player) return side;
  auto player = desktop::ScriptedUser::make(setup.applications, scene, setup.rig, setup.world, setup.seed,
                                            setup.player_extra_delay_s);
  if (!player) return tl::unexpected(player.error());
  side->player_.emplace(std::move(*player));
  return side;
}

Expected<void> GraphicsSide::make_renderer(const GraphicsSetup& setup) {
  auto view = setup.applications.find(scene_.application) != nullptr
                  ? setup.applications.make_view(scene_)
                  : std::make_unique<scene::GenericView>(scene_.application, scene_.shape_vertices);
  if (!view) return tl::unexpected(view.error());
  // Where the processor draws it has little to spare beside the loops.
  const auto drawing = render::Context::required();
  const auto first = drawing->is_software() ? render::Quality::low : render::Quality::medium;
  renderer_.emplace(setup.rig, scene_, std::move(*view), setup.quality.value_or(first));
  if (!setup.quality) quality_.emplace(first);
  renderer_->set_hand(setup.hand);
  return {};
}

void GraphicsSide::make_server(const GraphicsSetup& setup, graphics::FramePipeline& pipeline) {
  server_.emplace(setup.rig, *link_, devices_.tracker(), devices_.camera().device(), pipeline,
                  setup.graphics);
  if (auto* right = devices_.right_camera())
    server_->add_right_camera(*right, devices_.one_clock() && !setup.right_camera_own_clock);
  if (setup.tracker)
    server_->set_tracker_explanation([this] { return devices_.tracker_driver()->why_unheard(); });
}

const graphics::FrameRecord& GraphicsSide::finish(Instant<GraphicsClock> now, bool player_sees) {
  const graphics::FrameRecord& frame = server_->finish_frame(now);
  if (player_ && player_sees) player_->show(frame, *server_);
  return frame;
}

std::optional<std::string> GraphicsSide::choose_quality(const graphics::FrameRecord& frame,
                                                        Instant<GraphicsClock> drawn) {
  if (!quality_ || frame.rgb.empty()) return std::nullopt;
  auto words = quality_->frame(drawn, drawn - frame.begun, frame.camera_frame, frame.stamp);
  if (words) renderer_->set_quality(quality_->quality());
  return words;
}

void GraphicsSide::lead_hand(Instant<GraphicsClock> now) {
  if (player_) player_->act(now, *server_, *devices_.hand());
}

}  // namespace palpate::server::session
