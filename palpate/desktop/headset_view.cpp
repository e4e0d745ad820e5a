#include "palpate/desktop/headset_view.h"

#include <algorithm>
#include <array>

#include "palpate/core/log.h"
#include "palpate/desktop/drawing.h"
#include "palpate/scene/shown_tip.h"

namespace palpate::desktop {
namespace {

constexpr Log kViewLog("graphics");
constexpr Size kWordsSize{800, 600};                   // that letters are laid out for
constexpr double kPixelsPerM = 1000.0;                 // 800 px are 0.8 m, 1 m away: 44 degrees
constexpr double kWordsAway = 1.0, kWordsTop = -0.16;  // m: below where one looks
constexpr Duration kAskEvery = std::chrono::milliseconds(50);
constexpr Duration kSaidStands = std::chrono::seconds(6);

}  // namespace

Canvas stacked_words(Hud& hud, const HudContent& content, const std::string& said, std::uint64_t* version) {
  HudContent theirs;  // keys, figures and hints are for a desk
  theirs.score = content.score;
  theirs.warnings = content.warnings;
  theirs.paused = content.paused;
  theirs.hint = said;
  theirs.full_force_n = 0.0;
  const auto& panels = hud.lay_out(theirs, kWordsSize);
  constexpr std::array kShown{Hud::kWarnings, Hud::kPaused, Hud::kHint, Hud::kScore};
  int width = 0, height = 0;
  *version = 0;
  for (const auto place : kShown) {
    width = std::max(width, panels[place].canvas.width);
    height += panels[place].canvas.height;
    *version += panels[place].version;
  }
  if (width == 0) return {};
  Canvas stack(width, height);
  int top = 0;
  for (const auto place : kShown) {
    const Canvas& canvas = panels[place].canvas;
    if (canvas.width == 0) continue;
    put(stack, canvas, (width - canvas.width) / 2, top);
    top += canvas.height;
  }
  return stack;
}

Expected<std::unique_ptr<HeadsetView>> HeadsetView::open(const rig::Rig& rig,
                                                         const scene::SceneDescription& scene,
                                                         const HeadsetViewOptions& options) {
  auto lettering = Lettering::open();
  if (!lettering) return tl::unexpected(lettering.error());
  headset::HeadsetSettings settings;
  settings.clock = options.clock;
  const auto X_view_camera = rig.headset ? rig.headset->X_eyes_camera : headset::camera_between_the_eyes();
  if (rig.headset) settings.pose_delay = seconds(rig.headset->delay_s);
  settings.eyes = {{rig.camera->model, X_view_camera}};
  if (rig::has_two_eyes(rig)) {
    const auto X_left_right = rig::right_in_left(rig);
    settings.eyes.push_back(
        {rig.right_camera->model,
         {X_view_camera.rotation * X_left_right.rotation,
          X_view_camera.rotation * X_left_right.translation + X_view_camera.translation}});
  }
  if (!rig.headset && settings.eyes.size() == 2) {
    // Nobody has measured where they sit: the middle between them is the head's middle.
    const Vector3 half =
        0.5 * (settings.eyes[1].X_view_camera.translation - settings.eyes[0].X_view_camera.translation);
    for (auto& eye : settings.eyes) eye.X_view_camera.translation -= half;
  }
  std::optional<HeadsetLog> log;
  if (!options.out.empty()) {
    auto begun = HeadsetLog::begin(options.out);
    if (!begun) return tl::unexpected(begun.error());
    log.emplace(std::move(*begun));
  }
  auto opened = headset::Headset::open(settings);
  if (!opened) return tl::unexpected(opened.error());
  auto view = on(std::move(*opened), std::move(*lettering), scene, options);
  view->log_ = std::move(log);
  return view;
}

std::unique_ptr<HeadsetView> HeadsetView::on(std::unique_ptr<headset::Headset> headset,
                                             std::unique_ptr<Lettering> lettering,
                                             const scene::SceneDescription& scene,
                                             const HeadsetViewOptions& options) {
  return std::unique_ptr<HeadsetView>(
      new HeadsetView(std::move(headset), std::move(lettering), scene, options));
}

void HeadsetView::show(const server::graphics::FrameRecord& frame, Instant<GraphicsClock> now) {
  if (log_) log_->frame(frame);
  if (frame.rgb.empty()) return;
  if (frame.have_state && frame.pose_source != server::graphics::PoseSource::none) {
    const Point<World> tip{scene::shown_tip(frame.state, scene_)};
    distance_.look(frame.X_world_camera.inverse() * tip, now);
  }
  const auto begun = MonotonicClock<GraphicsClock>::monotonic_ns();
  headset_->show({frame.rgb, frame.width, frame.height, frame.image_time,
                  options_.distance.value_or(distance_.distance())});
  hand_over_.add(Duration(MonotonicClock<GraphicsClock>::monotonic_ns() - begun));
}

void HeadsetView::act(const HudContent& content, Instant<GraphicsClock> now) {
  if (log_) log_->head(*headset_, now);
  if (asked_ && now - *asked_ < kAskEvery) return;
  asked_ = now;
  follow_runtime(now);
  put_words(content, now);
  const auto shown = headset_->shown();
  if (!shown || shown->picture == seen_) return;
  seen_ = shown->picture;
  age_.add(shown->displayed - shown->image_time);
}

void HeadsetView::follow_runtime(Instant<GraphicsClock> now) {
  auto trouble = headset_->trouble(now);
  if (trouble.has_value() == trouble_.has_value()) return;
  if (trouble)
    kViewLog.warning("{}", *trouble);
  else
    kViewLog.info("headset: {} shows pictures again", headset_->facts().device);
  if (!trouble) words_version_ = 0;  // a runtime that was reached anew has none yet
  trouble_ = std::move(trouble);
}

void HeadsetView::say(std::string words, Instant<GraphicsClock> now) {
  said_ = std::move(words);
  said_at_ = now;
}

void HeadsetView::put_words(const HudContent& content, Instant<GraphicsClock> now) {
  if (now - said_at_ > kSaidStands) said_.clear();
  std::uint64_t version = 0;
  const Canvas words = stacked_words(hud_, content, said_, &version);
  if (version == words_version_) return;
  words_version_ = version;
  const double wide = words.width / kPixelsPerM, high = words.height / kPixelsPerM;
  headset_->show_panel(
      {words.rgba, words.width, words.height, wide, Vector3(0.0, kWordsTop - 0.5 * high, -kWordsAway)});
}

Json HeadsetView::figures() const {
  const headset::HeadsetFacts facts = headset_->facts();
  return {{"runtime", facts.runtime},
          {"device", facts.device},
          {"frames", facts.frames},
          {"with_picture", facts.with_picture},
          {"pictures", facts.pictures},
          {"pictures_shown", facts.pictures_shown},
          {"unplaced", facts.unplaced},
          {"losses", facts.losses},
          {"rate_hz", facts.display.known() ? 1.0 / to_seconds(facts.display.period) : 0.0},
          {"distance_m", options_.distance.value_or(distance_.distance())},
          {"age_ms", {{"median", 1e-3 * age_.us(0.5)}, {"p99", 1e-3 * age_.us(0.99)}}},
          {"hand_over_us", {{"median", hand_over_.us(0.5)}, {"p99", hand_over_.us(0.99)}}}};
}

}  // namespace palpate::desktop
