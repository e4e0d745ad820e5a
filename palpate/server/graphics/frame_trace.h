// Where the time of each frame goes: its stages, one after the other, and the whole of it, in a TraceLog.
//
// Times are of the machine's monotonic clock. One thread, the frame loop's.
#pragma once

#include <cstdint>

#include "palpate/core/trace_log.h"
#include "palpate/time/clock.h"

namespace palpate::server::graphics {

class FrameTrace {
 public:
  FrameTrace() : log_("graphics") {}

  // What comes next is a frame's work.
  void begin(std::uint64_t frame) {
    frame_ = frame;
    last_ns_ = now();
  }
  // A stage ends: it had begun where the one before ended, or at begin().
  void stage(const char* name) {
    const std::int64_t before = last_ns_;
    last_ns_ = now();
    log_.add(name, before, last_ns_, frame_);
  }
  void span(const char* name, std::int64_t begun_ns, std::int64_t ended_ns) {
    log_.add(name, begun_ns, ended_ns, frame_);
  }
  const TraceLog& log() const { return log_; }

 private:
  static std::int64_t now() { return MonotonicClock<GraphicsClock>::monotonic_ns(); }
  TraceLog log_;
  std::uint64_t frame_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace palpate::server::graphics
