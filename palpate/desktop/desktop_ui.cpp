#include "palpate/desktop/desktop_ui.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/text.h"
#include "palpate/desktop/scripted_user.h"
#include "palpate/device/timecode.h"
#include "palpate/haptics/force_limits.h"
#include "palpate/scene/shown_tip.h"

namespace palpate::desktop {
namespace {

constexpr double kIdleDraw_s = 0.05;       // between draws while no frames come
constexpr double kTimecodeDraw_s = 0.008;  // with the timecode: more often than a screen of 60 Hz changes
constexpr double kAskStatus_s = 0.1;       // how the forces are: told within 0.5 s
constexpr double kTakeOver_px = 12.0;      // a mouse that moved that far is meant
constexpr double kHintStands_s = 6.0;
constexpr std::int64_t kSameBeat_ns = 5'000'000;  // two clocks read one after the other tell of one word
constexpr double kRefusalStands_s = 3.0;
constexpr double kFirstWord_s = 3.0;  // while everything begins, an answer may take so long
constexpr Size kFirstSize{960, 720}, kFirstSizeOfTwo{1280, 480};

const scene::SceneSurface* surface_of(const scene::SceneDescription& scene, std::string_view name) {
  for (const auto& surface : scene.surfaces)
    if (surface.name == name) return &surface;
  return nullptr;
}

// kg, of each body that is heard when it meets another.
std::vector<double> heard_masses(const scene::SceneDescription& scene) {
  std::vector<double> masses;
  for (const auto& body : scene.bodies) masses.push_back(body.mass);
  return masses;
}

Vector3 middle_of(const scene::SceneSurface& surface) {
  const auto& c = surface.corners;
  return 0.25 * (c[0] + c[1] + c[2] + c[3]);
}

}  // namespace

MouseHandSettings mouse_hand_settings(const scene::SceneDescription& scene, const scene::Handling& handling,
                                      const rig::Rig& rig, const sim::config::WorldFile& world,
                                      std::optional<scene::ExploredSurface> explored) {
  constexpr double kStylusLean = 0.67;  // rad: as a pen is held
  MouseHandSettings settings;
  const scene::Reach reach = players_reach(rig, world);
  settings.reachable = [reach](const Vector3& tip) { return reach.contains(tip); };
  settings.max_acceleration = world.player.max_hand_acceleration;
  settings.max_speed = kSpeedShare * world.arm.max_speed;
  settings.offset = scene.carried_offset;
  if (const scene::SceneSurface* table = surface_of(scene, "table")) {
    const auto& c = table->corners;
    settings.right = (c[1] - c[0]).normalized();
    settings.up = (c[1] - c[0]).cross(c[3] - c[0]).normalized();
    settings.forward = settings.up.cross(settings.right);
  }
  const scene::SceneSurface* faced = surface_of(scene, handling.faces);
  if (faced != nullptr) {
    settings.faces = middle_of(*faced);
    settings.wheel = settings.forward;
  } else {
    // A stylus over something that lies on the table: the pointer moves it level, the wheel up and down, to both
    // ends of what the arm reaches.
    settings.lean = 0.5 * std::numbers::pi;
    settings.wheel = settings.up;
    settings.notch = 0.004;
    settings.farthest = 0.40;
    settings.stylus_lean = kStylusLean;
    if (explored) settings.surface = std::make_shared<PointedSurface>(std::move(*explored), settings.up);
  }
  // The tip in a comfortable place, what it carries where that puts it.
  settings.home = reach.home();
  const Quaternion R = MouseHand(rig.camera->model, settings).act(0.0).R_world_tip;
  settings.home += R * settings.offset;
  return settings;
}

DesktopUi::DesktopUi(const scene::SceneDescription& scene, const scene::Handling& handling,
                     const rig::Rig& rig, const DesktopUiOptions& options)
    : options_(options),
      scene_(scene),
      handling_(handling),
      camera_(rig.camera->model),
      full_force_n_(haptics::force_limits_of(rig.arm->model).peak_n),
      physics_silence_(seconds(Warnings::kPhysicsSilent_s).count()),
      picture_{rig.camera->model.width, rig.camera->model.height},
      person_plays_(options.mouse && !options.scripted_player),
      own_game_(person_plays_) {
  if (rig.right_camera) right_camera_ = rig.right_camera->model;
}

Expected<std::unique_ptr<DesktopUi>> DesktopUi::open(const scene::ApplicationRegistry& applications,
                                                     const scene::SceneDescription& scene,
                                                     const rig::Rig& rig, const sim::config::WorldFile& world,
                                                     const transport::ServerPlace& place,
                                                     const DesktopUiOptions& options) {
  auto opened = Window::open("Palpate", options.biocular || options.two_eyes ? kFirstSizeOfTwo : kFirstSize);
  if (!opened) return tl::unexpected(opened.error());
  const Window* window = opened->get();
  auto sound = SoundOut::open();
  auto ui = open_on(std::move(*opened), sound ? std::move(*sound) : nullptr, applications, scene, rig, world,
                    place, options);
  if (!ui) return ui;
  (*ui)->window_ = window;
  if (!sound) (*ui)->notice_ = sound.error().message + "; it plays on in silence";
  return ui;
}

Expected<std::unique_ptr<DesktopUi>> DesktopUi::open_on(
    std::unique_ptr<Screen> screen, std::unique_ptr<SoundOut> sound,
    const scene::ApplicationRegistry& applications, const scene::SceneDescription& scene, const rig::Rig& rig,
    const sim::config::WorldFile& world, const transport::ServerPlace& place,
    const DesktopUiOptions& options) {
  const scene::Handling& handling = applications.handling(scene.application);
  std::unique_ptr<DesktopUi> ui(new DesktopUi(scene, handling, rig, options));
  ui->screen_ = std::move(screen);
  auto hits = HitWatch::begin(place, heard_masses(scene), std::move(sound));
  if (!hits) return tl::unexpected(hits.error());
  ui->hits_ = std::move(*hits);
  std::unique_ptr<scene::InputAssist> assist;
  if (applications.find(scene.application) != nullptr) {
    auto made = applications.make_input_assist(scene, players_reach(rig, world), own_hand(world));
    if (!made) return tl::unexpected(made.error());
    assist = std::move(*made);
  }
  ui->helped_ = assist != nullptr;
  std::optional<scene::ExploredSurface> explored;
  if (applications.find(scene.application) != nullptr) {
    auto made = applications.explored(scene);
    if (!made) return tl::unexpected(made.error());
    explored = std::move(*made);
  }
  ui->explores_ = explored.has_value();
  if (explored && explored->full_force_n > 0.0) ui->full_force_n_ = explored->full_force_n;
  ui->leader_ = std::make_unique<HandLeader>(
      MouseHand(rig.camera->model, mouse_hand_settings(scene, handling, rig, world, std::move(explored))),
      std::move(assist));
  return ui;
}

void DesktopUi::show(const server::graphics::FrameRecord& frame, std::vector<std::string> captions,
                     Instant<GraphicsClock> now) {
  const double t = to_seconds(now.since_epoch);
  recent_.emplace_back(t, frame.late);
  while (recent_.size() > 2 && recent_.front().first < t - 1.0) recent_.pop_front();
  content_.score = std::move(captions);
  const double span = recent_.back().first - recent_.front().first;
  if (span > 0.3) content_.pictures_per_s = static_cast<double>(recent_.size() - 1) / span;
  const double delay = to_seconds(frame.drawn - frame.image_time);
  const double before = content_.delay_s.value_or(delay);
  content_.delay_s = before + 0.1 * (delay - before);
  hits_->set_delay(std::clamp(*content_.delay_s, 0.0, 0.5));
  if (frame.expected_world_px) {
    const double overlay_before = content_.overlay_px.value_or(*frame.expected_world_px);
    content_.overlay_px = overlay_before + 0.1 * (*frame.expected_world_px - overlay_before);
  } else {
    content_.overlay_px.reset();
  }
  if (!frame.rgb.empty()) take_picture(frame);
  if (frame.have_state) leader_->show(frame.state);
  frame_ = frame;
  frame_.rgb = {};
  aim();
  draw(now);
}

void DesktopUi::take_picture(const server::graphics::FrameRecord& frame) {
  std::span<const std::uint8_t> rgb = frame.rgb;
  Size size{frame.width, frame.height};
  eyes_ = options_.biocular ? 2 : std::max(1, frame.width / camera_.width);
  if (from_outside_) {
    const render::OutsidePicture& seen = options_.outside(frame);
    rgb = seen.rgb;
    size = {seen.width, seen.height};
  }
  std::vector<std::uint8_t> both;  // a single picture before both eyes
  if (eyes_ == 2 && size.width == camera_.width) {
    both = render::biocular(rgb, size.width, size.height);
    rgb = both;
    size.width *= 2;
  }
  picture_ = size;
  screen_->take_picture(rgb, picture_, eyes_);
  pictured_ = true;
}

// Which camera's picture the pointer is over, and where that stands.
void DesktopUi::aim() {
  if (from_outside_)
    leader_->look_through(options_.onlooker->viewpoint().camera,
                          options_.onlooker->viewpoint().X_world_camera);
  else if (frame_.pose_source == server::graphics::PoseSource::none)
    return;
  else if (over_right_ && frame_.right && right_camera_)
    leader_->look_through(*right_camera_, frame_.right->X_world_camera);
  else
    leader_->look_through(camera_, frame_.X_world_camera);
}

void DesktopUi::lead(device::HandDevice& hand, const MonotonicClock<GraphicsClock>& clock) {
  leader_->start(hand, clock);
  if (person_plays_) leader_->take_over(std::nullopt, clock.now());
}

void DesktopUi::take_over(Instant<GraphicsClock> now) {
  if (!options_.mouse || person_plays_) return;
  person_plays_ = true;
  taken_over_ = now;
  std::optional<device::HandTarget> at;
  if (frame_.have_state) {
    const auto& carried = frame_.state.bodies[scene::kCarried];
    at = device::HandTarget{{scene::shown_tip(frame_.state, scene_)}, carried.v(), carried.q()};
  }
  leader_->take_over(at, now);
}

void DesktopUi::say(std::string words, Instant<GraphicsClock> now) {
  said_ = std::move(words);
  said_at_ = now;
}

KeysInUse DesktopUi::keys_in_use() const {
  return {.mouse = options_.mouse,
          .strokes = options_.mouse && helped_,
          .program = options_.mouse && options_.scripted_player,
          .view = static_cast<bool>(options_.outside),
          .looks = static_cast<bool>(options_.next_look),
          .head = options_.mouse && options_.simulated_head,
          .explores = explores_,
          .handling = handling_};
}

void DesktopUi::program_or_person(Instant<GraphicsClock> now) {
  if (!options_.mouse || !options_.scripted_player)
    return say(options_.mouse             ? "Nobody else can play: `--player` seats the program beside you"
               : options_.scripted_player ? "The program plays: `--mouse` lets you do so"
                                          : "Who leads the arm plays",
               now);
  if (!person_plays_) {
    moved_px_ = kTakeOver_px;
    return;
  }
  left_ = leader_->let_go(now);
  person_plays_ = false;
  moved_px_ = 0.0;
}

void DesktopUi::hold_head(Instant<GraphicsClock> now) {
  if (!keys_in_use().head) return say("The head is your own here", now);
  const bool still = leader_->turn_head_still();
  if (!person_plays_) return say("The head moves while the program plays", now);
  say(still ? "The head is kept still. K: it moves again" : "The head moves again. K: it is kept still", now);
}

bool DesktopUi::obey(Key key, Instant<GraphicsClock> now, transport::StateLink& link) {
  switch (key) {
    case Key::serve:
      link.send_control(scene::Control::begin);
      break;
    case Key::pause:
      paused_ = !paused_;
      link.send_control(paused_ ? scene::Control::pause : scene::Control::resume);
      break;
    case Key::reset:
      link.send_control(scene::Control::reset);
      break;
    case Key::program_plays:
      program_or_person(now);
      break;
    case Key::strokes:
      if (!keys_in_use().strokes)
        say("There are no strokes to help with here", now);
      else
        say(*leader_->turn_help()
                ? fmt::format("The {} swings by itself. S: it only goes where you push it", handling_.held)
                : fmt::format("The {} only goes where you push it. S: it swings by itself", handling_.held),
            now);
      break;
    case Key::head:
      hold_head(now);
      break;
    case Key::full_screen:
      screen_->toggle_full_screen();
      break;
    case Key::view:
      from_outside_ = options_.outside && !from_outside_;
      say(from_outside_ ? "From the side. V: with your own eyes" : "", now);
      break;
    case Key::look:
      say(options_.next_look ? options_.next_look().value_or("") : "There is one way to draw this", now);
      break;
    case Key::help:
      content_.help = content_.help ? std::nullopt : std::optional(keys_in_use());
      break;
    case Key::farther:
      leader_->roll(1.0);
      break;
    case Key::nearer:
      leader_->roll(-1.0);
      break;
    case Key::escape:  // what stands over the picture first
      if (!content_.help) return false;
      content_.help.reset();
      break;
    case Key::quit:
      return false;
  }
  return true;
}

bool DesktopUi::act(Instant<GraphicsClock> now, transport::StateLink& link,
                    const std::vector<server::graphics::Condition>& conditions,
                    const ClockSync<GraphicsClock, PhysicsClock>& sync) {
  if (!begun_) begun_ = now;
  if (sync.exchanges() > 0) leader_->synchronised(sync.model());
  const Input input = screen_->poll();
  attended_ = attended_ || !input.keys.empty();
  for (const auto key : input.keys)
    if (!obey(key, now, link)) return false;
  moved_px_ += input.moved;
  if (input.left || input.right || input.wheel != 0.0) moved_px_ = kTakeOver_px;
  if (moved_px_ >= kTakeOver_px) {
    attended_ = true;
    take_over(now);
  }
  if (person_plays_ && !std::exchange(own_game_, true)) {
    link.send_control(scene::Control::reset);  // what the program has scored is not theirs
    own_game_begins_ = true;
  }
  if (input.pointer) {
    const Box box = letterbox(picture_, screen_->framebuffer());
    const device::Pixel pixel = picture_pixel(box, picture_, *input.pointer);
    over_right_ = eyes_ == 2 && pixel.x() >= 0.5 * picture_.width;
    aim();
    leader_->point(eye_pixel(pixel, picture_, eyes_));
  }
  leader_->roll(input.wheel);
  leader_->hold_buttons(input.left, input.right);
  look(now, link, conditions);
  if (!drawn_ || to_seconds(now - *drawn_) > (options_.timecode ? kTimecodeDraw_s : kIdleDraw_s)) draw(now);
  return true;
}

void DesktopUi::look(Instant<GraphicsClock> now, transport::StateLink& link,
                     const std::vector<server::graphics::Condition>& conditions) {
  const double t = to_seconds(now.since_epoch);
  if (!status_asked_ || to_seconds(now - *status_asked_) > kAskStatus_s) {
    status_asked_ = now;
    link.ask_status();
  }
  Standing c;
  c.felt = !options_.mouse;
  for (const auto& condition : conditions) c.devices.push_back(condition.words);
  if (headset_trouble_) c.devices.push_back(*headset_trouble_);
  c.since_physics_s = physics_silence_s(now, link);
  if (recent_.size() >= 5) {
    const auto late =
        std::count_if(recent_.begin(), recent_.end(), [](const auto& one) { return one.second; });
    c.late_share = static_cast<double>(late) / static_cast<double>(recent_.size());
  }
  c.state_old = frame_.have_state && frame_.answer == AnswerKind::too_old;
  if (const auto& status = link.status()) {
    c.failure = excerpt(status->failure, 160);
    for (const auto& loop : status->loops)
      if (loop.forces) {
        c.forces = loop.forces;
        c.culprit = loop.culprit;
      }
  }
  if (link.refusal() != refusal_seen_) {
    refusal_seen_ = link.refusal();
    refused_at_ = now;
  }
  if (refusal_seen_ && refused_at_ && to_seconds(now - *refused_at_) < kRefusalStands_s)
    c.refusal = excerpt(*refusal_seen_, 120);
  warnings_.look(t, c);
  // What an impact asks for is felt by nobody while forces are off.
  forces_off_ = !c.failure.empty() || (c.forces && c.forces->state == device::ForceState::safe);
  const double asked = hits_->take_force();
  if (!forces_off_) force_.feel(t, asked);
  force_.last(forces_off_ ? 0.0 : hits_->lasting_force());
}

// Since the physics server's last word, where it is too long ago; else 0.
double DesktopUi::physics_silence_s(Instant<GraphicsClock> now, const transport::StateLink& link) {
  const auto silence = link.since_last_word();
  const auto beat = silence ? (now - *silence).ns() : begun_->ns();
  if (std::abs(beat - physics_beat_ns_) > kSameBeat_ns) physics_beat_ns_ = beat;
  const bool gone = physics_silence_.gone(now.ns(), physics_beat_ns_);
  const bool heard = physics_beat_ns_ > begun_->ns() + kSameBeat_ns;  // while this window is open
  if (!gone || (!heard && to_seconds(now - *begun_) < kFirstWord_s)) return 0.0;
  return 1e-9 * static_cast<double>(now.ns() - physics_beat_ns_);
}

std::string DesktopUi::hint(double t) const {
  const auto since = [t](const std::optional<Instant<GraphicsClock>>& moment) {
    return moment ? t - to_seconds(moment->since_epoch) : 1e9;
  };
  if (!pictured_) return "Waiting for the first picture";
  if (since(said_at_) < kHintStands_s && !said_.empty()) return said_;
  if (options_.mouse && !person_plays_) {
    const double left = end_ && !attended_ ? -since(end_) : 0.0;  // s
    const std::string who =
        left > 0.0 ? fmt::format("The program plays, {:.0f} s more", std::ceil(left)) : "The program plays";
    return who + ". Move the mouse to take the " + handling_.held;
  }
  const bool fresh = since(taken_over_) < kHintStands_s || since(begun_) < kHintStands_s;
  if (!fresh) return "";
  return std::string(options_.mouse ? "You play. ? lists the keys" : "? lists the keys") +
         (hits_->heard() ? "" : ". No sound device: silent");
}

void DesktopUi::draw(Instant<GraphicsClock> now) {
  drawn_ = now;
  const double t = to_seconds(now.since_epoch);
  content_.warnings.clear();
  for (const auto& warning : warnings_.shown()) content_.warnings.push_back(warning.words);
  content_.force_n = forces_off_ ? 0.0 : force_.level(t);
  content_.last_force_n = forces_off_ ? 0.0 : force_.last_peak();
  content_.full_force_n = full_force_n_;
  content_.paused = paused_;
  content_.hint = hint(t);
  if (options_.timecode) timecode_ = now.since_epoch % device::kTimecodeCycle;
  screen_->draw(content_, timecode_);
}

}  // namespace palpate::desktop
