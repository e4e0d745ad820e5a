// Spans of time in one thread, as a file that Perfetto (ui.perfetto.dev) and chrome://tracing open: JSON of the Trace Event
// Format, "X" events.
//
// Times are nanoseconds of the machine's monotonic clock, so traces of several processes of one machine lie on one time line. A span within
// another is shown below it. Kept in memory until the end; what does not fit is counted and left out. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate::inline core {

class TraceLog {
 public:
  // `most`: spans; 40 bytes each.
  explicit TraceLog(std::string process, std::size_t most = 2'000'000);

  // `name` must outlive the log: a literal. `frame`: shown with it.
  void add(const char* name, std::int64_t begun_ns, std::int64_t ended_ns, std::uint64_t frame);
  std::size_t count() const { return spans_.size(); }
  std::uint64_t left_out() const { return left_out_; }

  std::string json() const;

 private:
  struct Span {
    const char* name;
    std::int64_t begun_ns, ended_ns;
    std::uint64_t frame;
  };
  std::string process_;
  std::size_t most_;
  std::uint64_t left_out_ = 0;
  std::vector<Span> spans_;
};

}  // namespace palpate::inline core
