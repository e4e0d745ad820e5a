// The side that listens.
#include <deque>
#include <map>
#include <set>

#include "drivers/ndi/internal/limits.h"
#include "drivers/ndi/protocol.h"
#include "drivers/ndi/reply_stream.h"
#include "palpate/core/text.h"

namespace palpate::drivers::ndi {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPatienceNs = 2'000 * kMs, kLongPatienceNs = 8'000 * kMs;  // for what moves hardware
// Between a reply with poses and the next request: shorter than the shortest frame of any of these devices (2.5 ms).
constexpr std::int64_t kPauseNs = kMs;
constexpr std::int64_t kLookAgainNs = 1'000 * kMs;  // for a tool that is plugged in
constexpr const char* kAskWithTime = "BX2:--6d=tools";
constexpr const char* kAskWithout = "BX:0001";

// What is asked for before poses come, in this order.
enum class Step {
  initialize,
  stop,  // another program had left it tracking
  list_stale,
  free_stale,
  request_handle,
  define,
  list_new,
  initialize_tool,
  list_ready,
  enable,
  name,
  start,
  track,
};

bool is_long(Step step) {
  return step == Step::initialize || step == Step::initialize_tool || step == Step::start;
}

std::string hex(std::string_view bytes, std::size_t count) {
  std::string digits;
  for (std::size_t i = 0; i < count; ++i)
    digits += fmt::format("{:02X}", i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0);
  return digits;
}

class Listener : public network::Conversation {
 public:
  explicit Listener(const ClientOptions& options) : options_(options) {}

  void begin(std::int64_t now_ns, Turn& turn) override { go_to(Step::initialize, now_ns, turn); }

  bool take(std::string_view bytes, std::int64_t now_ns, Turn& turn) override {
    bool alive = true;
    const bool fine = stream_.take(bytes, [&](Reply&& reply) {
      if (alive) alive = hear(reply, now_ns, turn);
    });
    if (!fine && alive) turn.trouble = stream_.complaint();
    return fine && alive;
  }

  std::optional<std::int64_t> due_ns() const override { return due_ns_; }

  bool ask(std::int64_t now_ns, Turn& turn) override {
    if (waiting_) {
      turn.trouble = fmt::format("no reply to {} within {} s; one is expected", command(),
                                 (is_long(step_) ? kLongPatienceNs : kPatienceNs) / (1'000 * kMs));
      return false;
    }
    if (step_ == Step::track)
      say(with_time_ ? kAskWithTime : kAskWithout, now_ns, turn);
    else
      go_to(step_, now_ns, turn);
    return true;
  }

  void end(Turn& turn) override {
    if (step_ == Step::track) turn.out += encode_command("TSTOP:");
  }

  Counts counts() const override { return counts_; }

 private:
  void say(std::string words, std::int64_t now_ns, Turn& turn) {
    turn.out += encode_command(words);
    said_ = std::move(words);
    waiting_ = true;
    due_ns_ = now_ns + (is_long(step_) ? kLongPatienceNs : kPatienceNs);
  }

  // Asks for the step, or goes on to the next where there is nothing to ask for.
  void go_to(Step step, std::int64_t now_ns, Turn& turn) {
    step_ = step;
    switch (step) {
      case Step::initialize:
        return say("INIT:", now_ns, turn);
      case Step::stop:
        return say("TSTOP:", now_ns, turn);
      case Step::list_stale:
        return say("PHSR:01", now_ns, turn);
      case Step::free_stale:
        if (handles_.empty()) return go_to(Step::request_handle, now_ns, turn);
        return say(fmt::format("PHF:{:02X}", handles_.front()), now_ns, turn);
      case Step::request_handle:
        if (defined_ == options_.wireless.size()) return go_to(Step::list_new, now_ns, turn);
        return say("PHRQ:*********1****", now_ns, turn);
      case Step::define:
        return say(next_block(), now_ns, turn);
      case Step::list_new:
        return say("PHSR:02", now_ns, turn);
      case Step::initialize_tool:
        if (handles_.empty()) return go_to(Step::list_ready, now_ns, turn);
        return say(fmt::format("PINIT:{:02X}", handles_.front()), now_ns, turn);
      case Step::list_ready:
        return say("PHSR:03", now_ns, turn);
      case Step::enable:
        if (handles_.empty()) return go_to(Step::name, now_ns, turn);
        return say(fmt::format("PENA:{:02X}D", handles_.front()), now_ns, turn);
      case Step::name:
        return name_next(now_ns, turn);
      case Step::start:
        return say("TSTART:", now_ns, turn);
      case Step::track:
        return say(with_time_ ? kAskWithTime : kAskWithout, now_ns, turn);
    }
  }

  std::string next_block() const {
    const auto& definition = options_.wireless[defined_];
    return fmt::format("PVWR:{:02X}{:04X}{}", defining_, written_,
                       hex(std::string_view(definition.bytes).substr(written_, kBlockBytes), kBlockBytes));
  }

  void name_next(std::int64_t now_ns, Turn& turn) {
    if (!unnamed_.empty()) return say(fmt::format("PHINF:{:02X}0005", unnamed_.front()), now_ns, turn);
    if (!names_.empty()) return go_to(Step::start, now_ns, turn);
    // A tool may be plugged in while one looks.
    turn.trouble =
        !tool_trouble_.empty()
            ? tool_trouble_
            : "the tracker has no tool that could be tracked; plug one in, or name definition files of "
              "wireless tools behind the address (/FILE.rom,...)";
    step_ = Step::list_new;
    due_ns_ = now_ns + kLookAgainNs;
  }

  // False: the connection is over.
  bool hear(const Reply& reply, std::int64_t now_ns, Turn& turn) {
    if (!waiting_)
      return over(turn, fmt::format("it says '{}' without being asked; a reply to each command is expected",
                                    reply.binary ? "(bytes)" : excerpt(reply.content)));
    waiting_ = false;
    due_ns_.reset();
    if (reply.damaged) {
      if (!reply.binary || step_ != Step::track)
        return over(turn,
                    fmt::format("it says '{}', without the checksum of the combined API; is this an NDI "
                                "tracker, as is expected",
                                reply.binary ? "(bytes)" : excerpt(reply.content)));
      ++counts_.damaged;
      turn.trouble = "a reply with poses was changed on its way; its checksum is expected";
      return pause(now_ns);
    }
    if (reply.binary) {
      if (step_ != Step::track) return over(turn, "it sends bytes; a text is expected");
      hear_poses(reply.content, now_ns, turn);
      return pause(now_ns);
    }
    if (const auto code = error_of(reply.content)) return hear_error(*code, now_ns, turn);
    if (reply.content.starts_with("WARNING"))
      turn.trouble = fmt::format("{}: {}", command(), excerpt(reply.content));
    return hear_text(reply.content, now_ns, turn);
  }

  bool pause(std::int64_t now_ns) {
    due_ns_ = now_ns + kPauseNs;
    return true;
  }

  bool over(Turn& turn, const std::string& why) {
    turn.trouble = fmt::format("{}: {}", command(), why);
    return false;
  }

  // What was said, without what a person need not see: blocks of definitions.
  std::string command() const {
    const bool whole = said_.size() <= 40 && !said_.ends_with(':');
    return whole ? said_ : said_.substr(0, said_.find(':'));
  }

  bool hear_error(Code code, std::int64_t now_ns, Turn& turn) {
    const auto words =
        fmt::format("{}: ERROR{:02X}, {}", command(), static_cast<unsigned>(code), words_of(code));
    switch (step_) {
      case Step::initialize:
        if (code == Code::not_in_this_mode && !stopped_) {
          stopped_ = true;
          go_to(Step::stop, now_ns, turn);
          return true;
        }
        break;
      case Step::stop:
        go_to(Step::initialize, now_ns, turn);
        return true;
      case Step::track:
        if (with_time_ && !heard_) {  // an older device
          with_time_ = false;
          go_to(Step::track, now_ns, turn);
          return true;
        }
        break;
      case Step::free_stale:
      case Step::initialize_tool:
      case Step::enable:  // without this one
        turn.trouble = tool_trouble_ = words;
        drop_first(now_ns, turn);
        return true;
      case Step::name:
        turn.trouble = words;
        name_first(std::nullopt, now_ns, turn);
        return true;
      default:
        break;
    }
    turn.trouble = words;
    return false;
  }

  void drop_first(std::int64_t now_ns, Turn& turn) {
    handles_.pop_front();
    go_to(step_, now_ns, turn);
  }

  bool hear_text(std::string_view words, std::int64_t now_ns, Turn& turn) {
    switch (step_) {
      case Step::initialize:
        if (words != "OKAY" && !words.starts_with("WARNING"))
          return over(turn, fmt::format("it says '{}'; OKAY is expected", excerpt(words)));
        go_to(Step::list_stale, now_ns, turn);
        return true;
      case Step::stop:
        go_to(Step::initialize, now_ns, turn);
        return true;
      case Step::list_stale:
        return hear_handles(words, Step::free_stale, now_ns, turn);
      case Step::request_handle:
        return begin_definition(words, now_ns, turn);
      case Step::define:
        written_ += kBlockBytes;
        if (written_ >= options_.wireless[defined_].bytes.size()) {
          ++defined_;
          go_to(Step::request_handle, now_ns, turn);
        } else {
          go_to(Step::define, now_ns, turn);
        }
        return true;
      case Step::list_new:
        return hear_handles(words, Step::initialize_tool, now_ns, turn);
      case Step::list_ready:
        return hear_handles(words, Step::enable, now_ns, turn);
      case Step::enable:
        unnamed_.push_back(handles_.front());
        [[fallthrough]];
      case Step::free_stale:
      case Step::initialize_tool:
        drop_first(now_ns, turn);
        return true;
      case Step::name: {
        auto info = decode_tool_info(words);
        if (!info) {
          ++counts_.refused;
          turn.trouble = info.error().message;
        }
        name_first(info ? *info : std::nullopt, now_ns, turn);
        return true;
      }
      case Step::start:
        go_to(Step::track, now_ns, turn);
        return true;
      case Step::track:
        break;
    }
    return over(turn, fmt::format("it says '{}'; poses are expected", excerpt(words)));
  }

  bool hear_handles(std::string_view words, Step next, std::int64_t now_ns, Turn& turn) {
    const auto handles = decode_handles(words);
    if (!handles) return over(turn, handles.error().message);
    handles_.clear();
    for (const auto& handle : *handles) handles_.push_back(handle.number);
    go_to(next, now_ns, turn);
    return true;
  }

  bool begin_definition(std::string_view words, std::int64_t now_ns, Turn& turn) {
    const auto handle = decode_handle(words);
    if (!handle) return over(turn, handle.error().message);
    defining_ = *handle;
    definitions_[*handle] = options_.wireless[defined_].tool;
    written_ = 0;
    go_to(Step::define, now_ns, turn);
    return true;
  }

  void name_first(const std::optional<ToolInfo>& info, std::int64_t now_ns, Turn& turn) {
    const auto handle = unnamed_.front();
    unnamed_.pop_front();
    std::string name = fmt::format("handle {:02X}", handle);
    if (const auto defined = definitions_.find(handle); defined != definitions_.end())
      name = defined->second;
    else if (info && !info->part_number.empty())
      name = info->part_number;
    else if (info && info->serial_number.find_first_not_of('0') != std::string::npos)
      name = info->serial_number;
    std::string unique = name;
    for (int i = 2; !taken_.insert(unique).second; ++i) unique = fmt::format("{}:{}", name, i);
    names_[handle] = unique;
    go_to(Step::name, now_ns, turn);
  }

  void hear_poses(std::string_view body, std::int64_t arrived, Turn& turn) {
    const auto refuse = [&](const Error& error) {
      ++counts_.refused;
      turn.trouble = error.message;
    };
    if (with_time_) {
      const auto frames = decode_bx2(body);
      if (!frames) return refuse(frames.error());
      for (const auto& frame : *frames)
        for (const auto& reading : frame.tools)
          keep(reading, reading.status != kFrameOutOfVolume, frame.stamp, arrived, turn);
    } else {
      const auto readings = decode_bx(body);
      if (!readings) return refuse(readings.error());
      for (const auto& reading : *readings)
        keep(reading, (reading.status & status::kOutOfVolume) == 0, std::nullopt, arrived, turn);
    }
    heard_ = true;
  }

  // A reply may hold what an earlier one held.
  void keep(const Reading& reading, bool in_volume, network::Stamp stamp, std::int64_t arrived, Turn& turn) {
    const auto name = names_.find(reading.handle);
    if (name == names_.end()) {
      ++counts_.skipped;
      return;
    }
    const bool seen = reading.state == Reading::State::valid && in_volume;
    const auto last = last_.find(reading.handle);
    const std::pair now(reading.frame, seen);
    if (last != last_.end() && last->second == now) return;
    last_[reading.handle] = now;
    turn.heard.push_back({.tool = name->second,
                          .stamp = stamp.value_or(Instant<TrackerClock>{Duration(arrived)}),
                          .server_time = stamp.has_value(),
                          .arrived_ns = arrived,
                          .seen = seen,
                          .pose = reading.pose});
  }

  const ClientOptions options_;
  ReplyStream stream_;
  Step step_ = Step::initialize;
  bool waiting_ = false;                // for the reply to what was said
  std::optional<std::int64_t> due_ns_;  // until when, or when to ask next
  std::string said_;
  bool stopped_ = false;

  std::deque<std::uint8_t> handles_;       // of this step, those still to do
  std::deque<std::uint8_t> unnamed_;       // enabled
  std::size_t defined_ = 0, written_ = 0;  // definitions; bytes of this one
  std::uint8_t defining_ = 0;
  std::map<std::uint8_t, std::string> definitions_;
  std::map<std::uint16_t, std::string> names_;  // of what is enabled
  std::set<std::string> taken_;
  std::string tool_trouble_;  // why a tool is not among them

  bool with_time_ = true, heard_ = false;
  std::map<std::uint16_t, std::pair<std::uint32_t, bool>> last_;  // frame, and whether it was seen in it
  Counts counts_;
};

}  // namespace

Expected<std::unique_ptr<network::PoseClient>> connect(const network::Address& server,
                                                       const ClientOptions& options) {
  return network::PoseClient::connect(server, [options] { return std::make_unique<Listener>(options); });
}

}  // namespace palpate::drivers::ndi
