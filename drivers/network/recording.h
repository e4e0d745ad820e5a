// A recording as a tracker that is played again: which pose is due when. Pure; whoever plays it owns the
// clock. One thread.
//
// Poses keep the stamps they were recorded with; in the second and later rounds of a loop the stamps go on
// from there, so that they never run backwards. Frames and units as in the file reader
// (palpate/device/pose_file.h): metres here. Errors: wrong use, with file and line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/network/tool_sample.h"
#include "palpate/core/expected.h"

namespace palpate::drivers::network {

struct RecordedPose {
  double time_s = 0.0;
  std::string tool;
  RigidPose pose;
};

// Sequences (.igs.mha): the transforms named, each of the file or a chain of those in it; all of the file's
// where none is named. Other files of poses hold one tool, "Tool" where it is not named. In order of time.
Expected<std::vector<RecordedPose>> read_recording(const std::filesystem::path& path,
                                                   const std::vector<std::string>& transforms = {});

class Replay {
 public:
  // `speed` above 0: 2 = twice as fast. Poses in order of time, at least one.
  Replay(std::vector<RecordedPose> poses, double speed = 1.0, bool loop = false);

  // The next pose where it is due at `elapsed` seconds after the start; none where it is not, or at the end.
  std::optional<RecordedPose> take(double elapsed);
  // When the next pose is due; none at the end.
  std::optional<double> next_due() const;

 private:
  double time_of_next() const;

  std::vector<RecordedPose> poses_;
  double speed_, period_;
  bool loop_;
  std::size_t next_ = 0, round_ = 0;
};

}  // namespace palpate::drivers::network
