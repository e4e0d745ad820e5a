// The only file that knows spdlog.
#include "palpate/core/log.h"

#include <fcntl.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <memory>

#include "palpate/core/file_descriptor.h"
#include "palpate/core/text.h"

namespace palpate::inline core {
namespace {

using Sink = std::shared_ptr<spdlog::sinks::sink>;

spdlog::level::level_enum level_of(LogLevel level) {
  switch (level) {
    case LogLevel::debug:
      return spdlog::level::debug;
    case LogLevel::info:
      return spdlog::level::info;
    case LogLevel::warning:
      return spdlog::level::warn;
    case LogLevel::error:
      return spdlog::level::err;
  }
  return spdlog::level::info;
}

LogLevel level_of(spdlog::level::level_enum level) {
  for (const auto ours : {LogLevel::debug, LogLevel::info, LogLevel::warning})
    if (level_of(ours) == level) return ours;
  return LogLevel::error;
}

// Hands lines to a function; the lock is that of Output.
class FunctionSink : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  explicit FunctionSink(LogSink function) : function_(std::move(function)) {}

 private:
  void sink_it_(const spdlog::details::log_msg& line) override {
    function_({level_of(line.level), line.time, std::string(line.payload.data(), line.payload.size())});
  }
  void flush_() override {}

  LogSink function_;
};

// Of the whole process, and never destroyed: threads may log until its very end.
class Output {
 public:
  static Output& get() {
    static auto* output = new Output;
    return *output;
  }
  void add(Sink sink) {
    const std::lock_guard lock(mutex_);
    sinks_.push_back(std::move(sink));
  }
  template <typename Kind>
  bool has() {
    const std::lock_guard lock(mutex_);
    return std::any_of(sinks_.begin(), sinks_.end(),
                       [](const Sink& sink) { return dynamic_cast<const Kind*>(sink.get()) != nullptr; });
  }
  std::vector<Sink> exchange(std::vector<Sink> sinks) {
    const std::lock_guard lock(mutex_);
    return std::exchange(sinks_, std::move(sinks));
  }
  void write(spdlog::level::level_enum level, const std::string& text) {
    const std::lock_guard lock(mutex_);
    if (const std::string trouble = put(level, text); !trouble.empty()) put(spdlog::level::warn, trouble);
  }

 private:
  // A sink that fails is left out from then on; returns why.
  std::string put(spdlog::level::level_enum level, const std::string& text) {
    std::string trouble;
    const spdlog::details::log_msg line(spdlog::log_clock::now(), {}, "", level, text);
    const auto fails = [&](const Sink& sink) {
      try {
        if (!sink->should_log(level)) return false;
        sink->log(line);
        sink->flush();
        return false;
      } catch (const std::exception& error) {
        trouble = fmt::format("warning: the log ends here: {}", one_line(error.what()));
        return true;
      }
    };
    sinks_.erase(std::remove_if(sinks_.begin(), sinks_.end(), fails), sinks_.end());
    return trouble;
  }

  std::mutex mutex_;
  std::vector<Sink> sinks_;
};

}  // namespace

std::string_view name_of(LogLevel level) {
  const auto name = spdlog::level::to_string_view(level_of(level));
  return {name.data(), name.size()};
}

void Log::write(LogLevel level, std::string_view text) const noexcept {
  try {
    const std::string_view part = part_;
    Output::get().write(level_of(level),
                        one_line(part.empty() ? std::string(text) : fmt::format("{}: {}", part, text)));
  } catch (const std::exception&) {  // no memory: whoever logs goes on without the line
  }
}

void log_to_standard_error() {
  if (Output::get().has<spdlog::sinks::stderr_sink_mt>()) return;
  auto sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  sink->set_level(spdlog::level::info);
  sink->set_pattern("palpate: %v");
  Output::get().add(std::move(sink));
}

Expected<void> log_to_file(const std::filesystem::path& path) {
  std::error_code none;
  const auto folder = path.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, none))
    return wrong_use("log {}: there is no folder {}; create it first", path.string(), folder.string());
  // A pipe that nobody reads would keep whoever opens it; where somebody does, this holds it open meanwhile.
  FileDescriptor pipe;
  const bool is_pipe = std::filesystem::is_fifo(path, none);
  if (is_pipe) pipe = FileDescriptor(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK));
  if (is_pipe && !pipe && errno == ENXIO)
    return wrong_use("log {}: nobody reads this pipe; start its reader first, or name a file", path.string());
  try {
    auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path.string());
    sink->set_level(spdlog::level::debug);
    sink->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %-7l %v");
    Output::get().add(std::move(sink));
  } catch (const spdlog::spdlog_ex& error) {
    return wrong_use("log {}: cannot be opened for writing ({})", path.string(), error.what());
  }
  return {};
}

void log_to(LogSink sink) { Output::get().add(std::make_shared<FunctionSink>(std::move(sink))); }

void log_to_nobody() { Output::get().exchange({}); }

LogCapture::LogCapture() {
  const auto keep = [this](const LogLine& line) {
    const std::lock_guard lock(mutex_);
    lines_.push_back(line);
  };
  before_ =
      std::make_shared<std::vector<Sink>>(Output::get().exchange({std::make_shared<FunctionSink>(keep)}));
}

LogCapture::~LogCapture() { Output::get().exchange(*std::static_pointer_cast<std::vector<Sink>>(before_)); }

std::vector<LogLine> LogCapture::lines() const {
  const std::lock_guard lock(mutex_);
  return lines_;
}

std::string LogCapture::text() const {
  std::string all;
  for (const auto& line : lines()) all += line.text + "\n";
  return all;
}

}  // namespace palpate::inline core
