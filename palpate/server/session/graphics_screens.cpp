#include "palpate/server/session/graphics_screens.h"

#include <utility>

#include "palpate/core/log.h"

namespace palpate::server::session {
namespace {

constexpr Log kScreensLog("graphics");

}  // namespace

Expected<std::unique_ptr<GraphicsScreens>> GraphicsScreens::open(const GraphicsProcessOptions& options,
                                                                 GraphicsSide& side,
                                                                 const transport::ServerPlace& place,
                                                                 const MonotonicClock<GraphicsClock>& clock) {
  std::unique_ptr<GraphicsScreens> screens(new GraphicsScreens(options, side, clock));
  if (auto opened = screens->open_windows(place); !opened) return tl::unexpected(opened.error());
  if (auto opened = screens->open_headset(); !opened) return tl::unexpected(opened.error());
  return screens;
}

GraphicsScreens::~GraphicsScreens() { side_.server().set_display({}); }

Expected<void> GraphicsScreens::open_windows(const transport::ServerPlace& place) {
  if (!options_.window) return {};
  const auto from_outside = [this](const graphics::FrameRecord& frame) -> const render::OutsidePicture& {
    return side_.renderer()->outside(frame);
  };
  if (options_.mouse) side_.renderer()->draw_for_window();
  std::function<std::optional<std::string>()> next_look;
  if (side_.renderer()->has_looks()) next_look = [this] { return side_.renderer()->next_look(); };
  auto opened =
      desktop::DesktopUi::open(options_.applications, side_.scene(), options_.rig, options_.world, place,
                               {.mouse = options_.mouse,
                                .scripted_player = options_.player,
                                .timecode = options_.timecode && side_.devices().live_camera() != nullptr,
                                .biocular = options_.biocular,
                                .two_eyes = side_.devices().right_camera() != nullptr,
                                .outside = from_outside,
                                .onlooker = &side_.renderer()->onlooker(),
                                .simulated_head = side_.devices().live_camera() == nullptr,
                                .next_look = next_look});
  if (!opened) return tl::unexpected(opened.error());
  ui_ = std::move(*opened);
  if (!ui_->notice().empty()) kScreensLog.write(LogLevel::info, ui_->notice());
  if (!options_.monitor) return {};
  auto monitor = desktop::SpectatorWindow::open(*options_.monitor, ui_->window(), from_outside,
                                                side_.renderer()->onlooker());
  if (!monitor) return tl::unexpected(monitor.error());
  monitor_ = std::move(*monitor);
  return {};
}

Expected<void> GraphicsScreens::open_headset() {
  if (!options_.headset) return {};
  auto opened = desktop::HeadsetView::open(
      options_.rig, side_.scene(),
      {.distance = options_.headset_distance, .clock = clock_, .out = options_.out});
  if (!opened) return tl::unexpected(opened.error());
  headset_ = std::move(*opened);
  side_.server().set_display(
      [this](Instant<GraphicsClock> finished) { return headset_->display_time(finished); });
  const headset::HeadsetFacts facts = headset_->headset().facts();
  kScreensLog.info("shows pictures in the headset {} ({})", facts.device, facts.runtime);
  return {};
}

void GraphicsScreens::show(const graphics::FrameRecord& frame) {
  if (headset_) headset_->show(frame, clock_.now());  // copies alone, and is to be seen soon
  if (!ui_ && !headset_) return;
  std::vector<std::string> captions;
  if (frame.have_state) captions = side_.renderer()->captions(frame.state);
  headset_words_.score = captions;
  if (ui_) ui_->show(frame, std::move(captions), clock_.now());
}

void GraphicsScreens::show_to_others(const graphics::FrameRecord& frame) {
  if (monitor_)
    monitor_->show({frame, ui_->from_outside(), ui_->content()}, options_.rig.camera->model.width, clock_);
}

void GraphicsScreens::say(const std::string& words) {
  const auto now = clock_.now();
  if (ui_) ui_->say(words, now);
  if (headset_) headset_->say(words, now);
}

bool GraphicsScreens::act() {
  act_for_headset();
  const graphics::GraphicsServer& server = side_.server();
  return !ui_ || ui_->act(clock_.now(), side_.link(), server.conditions(), server.sync());
}

void GraphicsScreens::act_for_headset() {
  if (!headset_) return;
  headset_words_.warnings.clear();
  for (const auto& condition : side_.server().conditions())
    headset_words_.warnings.push_back(condition.words);
  headset_->act(ui_ ? ui_->content() : headset_words_, clock_.now());
  if (ui_) ui_->set_headset_trouble(headset_->trouble());
}

void GraphicsScreens::act_for_others() {
  if (!monitor_ || monitor_->act(ui_->content(), clock_.now())) return;
  kScreensLog.info("the monitor window is closed; the play goes on");
  monitored_ = monitor_->figures();
  monitor_.reset();
}

Expected<void> GraphicsScreens::finish() { return headset_ ? headset_->finish() : Expected<void>{}; }

void GraphicsScreens::add_figures(Json& result) const {
  if (ui_)
    result["window"] = {{"played_by_mouse", ui_->person_plays()},
                        {"blows_heard", ui_->impacts()},
                        {"bounces_heard", ui_->bounces()}};
  if (headset_) result["headset"] = headset_->figures();
  const Json monitored = monitor_ ? monitor_->figures() : monitored_;
  if (!monitored.is_null()) result["window"]["monitor"] = monitored;
}

}  // namespace palpate::server::session
