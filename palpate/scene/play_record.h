// What an application keeps of a play for those who look at it afterwards: its tables, which lie beside the
// system's in raw/, its part of summary.json and of a demo's last lines, and which moments are worth a picture.
//
// Fed with states in order; World frame, SI. What it writes names its units (`depth_mm`). One thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/device/camera_model.h"
#include "palpate/scene/scene_state.h"

namespace palpate::scene {

// A picture that a player was shown, without its pixels.
struct ShownPicture {
  const SceneState& state;  // as it was drawn; means nothing without have_state
  bool have_state = false;
  const device::CameraModel& lens;
  Pose<World, CameraOptical> X_world_camera;

  // The point lies before the camera and within the frame, whatever may stand between.
  bool shows(const Vector3& point) const;
};

// What a picture shows, and whether it is one to keep. Words are in lower case, without a full stop.
struct Highlight {
  bool in_sight = true;     // what the play is about can be seen
  std::int32_t events = 0;  // hits, touches: how many so far; the first ones get a picture each
  std::string event;        // one such, as a word of a file's name: "hit"
  std::string just_after;   // what a picture right after one shows: "the tip has just met the surface"
  std::string going_on;     // what any other shows: "the ball on its way to the wall"
  std::string unseen;       // and where it is not in sight
};

// A file of raw/: what it is called and what it holds, a few words for a reader.
struct PlayTable {
  std::string file, holds;
};

// One of the lines that a demo ends with: "rally:    4 of 5 serves returned".
struct ClosingLine {
  std::string about, text;
};

// As it stands it keeps nothing, and every moment in which the first body is shown is as good as any other.
class PlayRecord {
 public:
  virtual ~PlayRecord() = default;

  // Each state of the physics loop.
  virtual void add_state(const SceneState&) {}
  // The state that each picture was drawn with.
  virtual void add_picture(const SceneState&) {}

  virtual Highlight highlight(const ShownPicture& picture) const;
  // The content of each of ApplicationSpec::tables, in their order: CSV with a header.
  virtual std::vector<std::string> tables() const { return {}; }
  // Keys of summary.json, each a part of its own.
  virtual Json summary() const { return Json::object(); }
  // `summary`: all of summary.json. They tell what stands there alone: of a person's own game, which another record has
  // seen, it is asked with that game's keys in place of the play's, and without `force`, which is of all who played.
  virtual std::vector<ClosingLine> closing_lines(const Json& /*summary*/) const { return {}; }
};

}  // namespace palpate::scene
