// The recording of a session of several processes: each server records into a file of its own beside the one that was asked for,
// and at the end they become that one. Whatever breaks off in between leaves the servers' files, which `palpate recording merge`
// makes one of.
//
// One thread. Errors: wrong use where one of the files is there already; refused where one cannot be read or written.
#pragma once

#include <filesystem>

#include "palpate/core/expected.h"

namespace palpate::tools::demo {

class JointRecording {
 public:
  JointRecording() = default;  // nothing is recorded
  explicit JointRecording(std::filesystem::path file) : file_(std::move(file)) {}

  bool wanted() const { return !file_.empty(); }
  // "s.physics.mcap" beside "s.mcap"; empty where nothing is recorded.
  std::filesystem::path physics() const { return part("physics"); }
  std::filesystem::path graphics() const { return part("graphics"); }

  // Before anything begins.
  Expected<void> check() const;
  // Once both servers have ended; their files are gone then.
  Expected<void> join() const;

 private:
  std::filesystem::path part(const char* server) const;
  std::filesystem::path file_;
};

}  // namespace palpate::tools::demo
