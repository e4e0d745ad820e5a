// A real person as a calibration session knows them: told on a panel what to do, and seen in the devices' streams.
//
// A pose counts when the marker is held still; a touch when a key says that the tip is there and it is held still; a
// movement when a key says that it has begun. Nothing is hurried: a session waits for the person, who may skip a
// pose, say that there are no more landmarks, or break off. World frame, SI. One thread.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <utility>

#include "palpate/calibration/session/stillness.h"
#include "palpate/device/person.h"

namespace palpate::calibration::session {

enum class PanelKey : std::uint8_t { proceed, no_more, skip, stop };

// A marker as the tracker shows it now. Without `seen` the pose is none.
struct SeenMarker {
  bool seen = false, still = false;
  Quaternion rotation = Quaternion::Identity();  // in World
  Vector3 translation = Vector3::Zero();         // World, m
};

// What the devices show of the person at a moment, for a panel that draws.
struct PersonView {
  double now_s = 0.0;  // host time
  bool arm_answers = true;
  SeenMarker stylus, pointer, head;  // head: the camera's marker
  bool near_target = false;          // of a pose that is shown: about there
};

// Where the person reads and answers: a terminal, a window.
class Panel {
 public:
  virtual ~Panel() = default;
  // What is to be done now, and which keys mean what; stays until the next.
  virtual void show(const device::Request& request, const std::string& text) = 0;
  // How it is going, in place of what was said before; some times a second.
  virtual void tell(const std::string& line) = 0;
  // The same as values, twenty times a second.
  virtual void observe(const PersonView& view) { static_cast<void>(view); }
  // What was asked for is over, and the next has not come: for who has to put something down.
  virtual void released() {}
  // A pose or a touch has been taken, a movement is being recorded: a sound.
  virtual void taken() = 0;
  // Pressed since the last call; one at a time.
  virtual std::optional<PanelKey> key() = 0;
};

class GuidedPerson : public device::Person {
 public:
  explicit GuidedPerson(Panel& panel, StillnessSettings settings = {});

  Expected<void> ask(const device::Request& request) override;
  // Asks for nothing: a key that answered this would be taken for an answer to what comes next.
  Expected<void> release() override;
  Expected<bool> ready() override;
  std::optional<double> patience() const override { return std::nullopt; }
  void watch(double now_s, const device::ArmSample& arm,
             std::span<const device::TrackerSample> tracked) override;

 private:
  Stillness& watched();
  std::string progress();
  PersonView seen_now(bool arm_answers) const;
  bool near_target() const;
  Expected<bool> answer(PanelKey key);
  bool there();

  Panel& panel_;
  device::Request request_;
  std::set<std::pair<std::string, int>> touched_;  // what has been asked for
  Stillness stylus_, pointer_, head_;
  bool pressed_ = false;
  double now_s_ = 0.0, told_s_ = -1.0, observed_s_ = -1.0;
};

// What a person is asked for, in words; the keys that answer included.
std::string instruction(const device::Request& request);

}  // namespace palpate::calibration::session
