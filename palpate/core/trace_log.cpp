#include "palpate/core/trace_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <iterator>
#include <utility>

#include "palpate/core/json.h"

namespace palpate::inline core {

TraceLog::TraceLog(std::string process, std::size_t most) : process_(std::move(process)), most_(most) {}

void TraceLog::add(const char* name, std::int64_t begun_ns, std::int64_t ended_ns, std::uint64_t frame) {
  if (spans_.size() >= most_)
    ++left_out_;
  else
    spans_.push_back({name, begun_ns, ended_ns, frame});
}

// Microseconds, as the format wants them.
std::string TraceLog::json() const {
  const auto pid = ::getpid();
  const auto quoted = [](const std::string& words) { return Json(words).dump(); };
  std::string text = R"({"displayTimeUnit":"ms","traceEvents":[)";
  fmt::format_to(std::back_inserter(text),
                 R"({{"name":"process_name","ph":"M","pid":{},"tid":{},"args":{{"name":{}}}}})", pid, pid,
                 quoted(process_));
  for (const Span& span : spans_)
    fmt::format_to(std::back_inserter(text),
                   ",\n{{\"name\":{},\"ph\":\"X\",\"pid\":{},\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f},"
                   "\"args\":{{\"frame\":{}}}}}",
                   quoted(span.name), pid, pid, 1e-3 * static_cast<double>(span.begun_ns),
                   1e-3 * static_cast<double>(span.ended_ns - span.begun_ns), span.frame);
  return text + "]}\n";
}

}  // namespace palpate::inline core
