// A person in front of the graphics server's picture: the window, the mouse as their hand, and what they are
// told.
//
// Frames go in as they are drawn; keys become wishes to the physics server; the mouse, where it holds the
// stylus, leads a HandDevice. A scripted player may hold the stylus until the person first moves the mouse.
// Main thread alone, which is also the frame loop's; act() takes well under a millisecond except where it
// draws.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/desktop/force_bar.h"
#include "palpate/desktop/hand_leader.h"
#include "palpate/desktop/hit_watch.h"
#include "palpate/desktop/mouse_hand.h"
#include "palpate/desktop/warnings.h"
#include "palpate/desktop/window.h"
#include "palpate/device/devices.h"
#include "palpate/device/heartbeat_monitor.h"
#include "palpate/render/outside_view.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::desktop {

struct DesktopUiOptions {
  bool mouse = false;            // holds the stylus
  bool scripted_player = false;  // holds it until the mouse moves
  bool timecode = false;         // over the picture, drawn anew as often as a screen changes
  bool biocular = false;         // one camera's picture before both eyes, side by side
  bool two_eyes = false;         // frames have a picture for each eye, side by side
  // A frame as it is seen from the side, and the eye it is seen with; none: it cannot be turned there.
  std::function<const render::OutsidePicture&(const server::graphics::FrameRecord&)> outside;
  const render::Onlooker* onlooker = nullptr;  // who sees it so; needed where `outside` is there
  bool simulated_head = false;                 // moves with the hand's device, and can be held still
  // Draws in the next of several ways from now on, and says in which; none: there is one way alone.
  std::function<std::optional<std::string>()> next_look{};
};

// How the mouse moves this rig's stylus in this scene. `explored`: over what it leads the tip, if anything; throws
// std::invalid_argument for a mesh that is none.
MouseHandSettings mouse_hand_settings(const scene::SceneDescription& scene, const scene::Handling& handling,
                                      const rig::Rig& rig, const sim::config::WorldFile& world,
                                      std::optional<scene::ExploredSurface> explored = std::nullopt);

class DesktopUi {
 public:
  // Refused where no window can be had; without sound it goes on, and says so in notice().
  // An application that is not among `applications` is led with the bare stylus.
  static Expected<std::unique_ptr<DesktopUi>> open(const scene::ApplicationRegistry& applications,
                                                   const scene::SceneDescription& scene, const rig::Rig& rig,
                                                   const sim::config::WorldFile& world,
                                                   const transport::ServerPlace& place,
                                                   const DesktopUiOptions& options);
  // The same on another screen, silent where there is no sound.
  static Expected<std::unique_ptr<DesktopUi>> open_on(
      std::unique_ptr<Screen> screen, std::unique_ptr<SoundOut> sound,
      const scene::ApplicationRegistry& applications, const scene::SceneDescription& scene,
      const rig::Rig& rig, const sim::config::WorldFile& world, const transport::ServerPlace& place,
      const DesktopUiOptions& options);

  // A frame has been drawn; `captions` are its score.
  void show(const server::graphics::FrameRecord& frame, std::vector<std::string> captions,
            Instant<GraphicsClock> now);
  // From now on the mouse leads this hand whenever it plays (hand_leader.h); both must outlive this object.
  // Only while person_plays() is false may another move it.
  void lead(device::HandDevice& hand, const MonotonicClock<GraphicsClock>& clock);
  // Every millisecond or so: reads mouse and keys, keeps the window alive when no frames come. `conditions`
  // of the graphics server are shown. Strokes that help the mouse are timed by the physics host's time, where
  // it is known. False when the person has quit.
  bool act(Instant<GraphicsClock> now, transport::StateLink& link,
           const std::vector<server::graphics::Condition>& conditions,
           const ClockSync<GraphicsClock, PhysicsClock>& sync);

  // To the person, for some seconds: what a key did, what has changed by itself.
  void say(std::string words, Instant<GraphicsClock> now);

  // Why a headset beside the window shows nothing new; none: it does, or there is none.
  void set_headset_trouble(const std::optional<std::string>& words) { headset_trouble_ = words; }

  // It shows the play from the side; the score, warnings and all else that stands over the picture.
  bool from_outside() const { return from_outside_; }
  const HudContent& content() const { return content_; }
  const Window& window() const { return *window_; }  // of open() alone

  // The timecode that was drawn last, once; just after show() or act() it has gone to the screen.
  std::optional<Duration> take_timecode() { return std::exchange(timecode_, {}); }

  bool person_plays() const { return person_plays_; }
  // Where a person has just left the hand to the program, once.
  std::optional<device::HandTarget> take_left() { return std::exchange(left_, {}); }
  // Somebody is there: a key has been pressed or the mouse moved.
  bool attended() const { return attended_; }
  // The person has just taken the stylus from the program for the first time, once: their own game begins at zero.
  bool take_own_game() { return std::exchange(own_game_begins_, false); }
  // Where nobody comes, the session ends then, which a person should know; none: it goes on.
  void set_end(std::optional<Instant<GraphicsClock>> end) { end_ = end; }
  // What the person should know from the start, a line for the log; empty: nothing.
  const std::string& notice() const { return notice_; }
  // For the process' figures.
  std::uint64_t impacts() const { return hits_ ? hits_->impacts() : 0; }
  std::uint64_t bounces() const { return hits_ ? hits_->bounces() : 0; }

 private:
  DesktopUi(const scene::SceneDescription& scene, const scene::Handling& handling, const rig::Rig& rig,
            const DesktopUiOptions& options);
  bool obey(Key key, Instant<GraphicsClock> now, transport::StateLink& link);
  void program_or_person(Instant<GraphicsClock> now);
  void hold_head(Instant<GraphicsClock> now);
  KeysInUse keys_in_use() const;
  void take_over(Instant<GraphicsClock> now);
  void take_picture(const server::graphics::FrameRecord& frame);
  void look(Instant<GraphicsClock> now, transport::StateLink& link,
            const std::vector<server::graphics::Condition>& conditions);
  double physics_silence_s(Instant<GraphicsClock> now, const transport::StateLink& link);
  void aim();
  void draw(Instant<GraphicsClock> now);
  std::string hint(double t) const;

  DesktopUiOptions options_;
  scene::SceneDescription scene_;
  scene::Handling handling_;
  device::CameraModel camera_;
  std::optional<device::CameraModel> right_camera_;
  double full_force_n_;
  std::unique_ptr<Screen> screen_;
  const Window* window_ = nullptr;  // the same, where it is one
  std::unique_ptr<HitWatch> hits_;
  std::unique_ptr<HandLeader> leader_;
  ForceBar force_;
  Warnings warnings_;
  bool forces_off_ = false;
  std::string notice_;
  std::optional<std::string> headset_trouble_;

  std::optional<Instant<GraphicsClock>> begun_, drawn_, status_asked_, taken_over_, said_at_, end_;
  std::string said_;  // what has changed and cannot be seen at once
  std::optional<device::HandTarget> left_;
  HudContent content_;
  server::graphics::FrameRecord frame_;  // without pixels
  std::optional<Duration> timecode_;
  // Silence counts while this loop runs itself.
  device::HeartbeatMonitor physics_silence_;
  std::int64_t physics_beat_ns_ = 0;
  Size picture_;
  int eyes_ = 1;                                    // side by side in it
  bool from_outside_ = false, over_right_ = false;  // over_right_: the pointer is in the right eye's half
  std::deque<std::pair<double, bool>> recent_;      // time and lateness of the last second's frames
  std::optional<std::string> refusal_seen_;
  std::optional<Instant<GraphicsClock>> refused_at_;
  double moved_px_ = 0.0;
  bool person_plays_ = false, attended_ = false, paused_ = false, helped_ = false, explores_ = false;
  bool pictured_ = false;  // a picture has come
  bool own_game_ = false, own_game_begins_ = false;
};

}  // namespace palpate::desktop
