#include "drivers/ndi/internal/simulated_device.h"

#include <algorithm>

#include "drivers/ndi/internal/limits.h"
#include "drivers/ndi/protocol.h"

namespace palpate::drivers::ndi {
namespace {

constexpr std::int64_t kSeenNs = 500'000'000;
constexpr std::size_t kMostSights = 1024;
// Of a reply to BX2: programs of others read into 2048 bytes.
constexpr std::size_t kMostReply = 1900;
constexpr std::uint8_t kMostHandles = 0xff;

std::string part_number(const std::string& tool) { return tool.substr(0, kPartNumberBytes); }

std::string part_number_in(const std::string& definition) {
  if (definition.size() < kPartNumberAt + kPartNumberBytes) return "";
  const auto text = definition.substr(kPartNumberAt, kPartNumberBytes);
  return text.substr(0, text.find('\0'));
}

std::uint32_t bits(bool initialized, bool enabled) {
  return status::kOccupied | (initialized ? status::kInitialized : 0) | (enabled ? status::kEnabled : 0);
}

}  // namespace

void SimulatedDevice::plug_in(const std::string& tool) {
  if (std::find(tools_.begin(), tools_.end(), tool) == tools_.end()) tools_.push_back(tool);
}

void SimulatedDevice::pose(const network::PublishedPose& pose) {
  const std::int64_t stamp_ns = pose.stamp ? pose.stamp->ns() : pose.at_ns;
  auto& newest = newest_[pose.tool];
  // A tool comes once in a frame, and all of a frame have one time.
  if (last_.frame == 0 || stamp_ns != last_.stamp_ns || newest.frame == last_.frame)
    last_ = {.frame = last_.frame + 1, .stamp_ns = stamp_ns, .at_ns = pose.at_ns, .tools = {}};
  newest = {pose.pose, pose.at_ns, last_.frame};
  if (!asked_) return;
  if (sights_.empty() || sights_.back().frame != last_.frame) sights_.push_back(last_);
  sights_.back().tools.emplace_back(pose.tool, pose.pose);
  if (sights_.size() > kMostSights) sights_.pop_front();
}

std::string SimulatedDevice::answer(const Command& command, std::int64_t now_ns) {
  const auto& name = command.name;
  if (name == "COMM") return encode_text("OKAY");  // a serial line's speed: of no account here
  if (name == "APIREV") return encode_text(timestamps_ ? "G.003.001" : "G.001.005");
  if (name == "VER") return encode_text("Palpate\nA recording in a tracker's place\nG.003.001\n");
  if (name == "TSTOP") {
    if (!tracking_) return encode_error(Code::not_in_this_mode);
    tracking_ = asked_ = false;
    sights_.clear();
    return encode_text("OKAY");
  }
  const bool with_time = name == "BX2" && timestamps_;
  if (name == "TX" || name == "BX" || with_time) {
    if (!tracking_) return encode_error(Code::not_in_this_mode);
    return with_time ? since_last_asked(now_ns) : newest(command, now_ns);
  }
  static constexpr std::string_view kSetUp[] = {"INIT", "TSTART", "PHSR", "PHRQ", "PVWR",
                                                "PHF",  "PINIT",  "PENA", "PDIS", "PHINF"};
  if (std::find(std::begin(kSetUp), std::end(kSetUp), name) == std::end(kSetUp))
    return encode_error(Code::unknown_command);
  if (tracking_) return encode_error(Code::not_in_this_mode);
  if (name == "INIT") return initialize();
  return initialized_ ? while_set_up(command) : encode_error(Code::system_not_initialized);
}

std::string SimulatedDevice::initialize() {
  initialized_ = true;
  ports_.clear();
  for (const auto& tool : tools_) {
    Port port;
    port.tool = tool;
    ports_.emplace(static_cast<std::uint8_t>(ports_.size() + 1), std::move(port));
  }
  return encode_text("OKAY");
}

std::string SimulatedDevice::while_set_up(const Command& command) {
  const auto& name = command.name;
  if (name == "TSTART") {
    tracking_ = true;
    for (auto& [handle, port] : ports_) port.told_missing = false;
    return encode_text("OKAY");
  }
  if (name == "PHSR") return list(command.parameters);
  if (name == "PHRQ") return request_handle(command.parameters);
  if (name == "PVWR") return write_definition(command.parameters);
  return of_handle(command);
}

// 00 all, 01 to be freed, 02 to be initialized, 03 to be enabled, 04 enabled.
std::string SimulatedDevice::list(const std::string& parameters) const {
  std::uint32_t which = 0;
  if (!parameters.empty() && !read_hex(parameters, which)) return encode_error(Code::wrong_parameters);
  if (which > 4) return encode_error(Code::out_of_range);
  std::vector<Handle> handles;
  for (const auto& [number, port] : ports_) {
    const bool wanted = which == 0 || (which == 2 && !port.initialized) ||
                        (which == 3 && port.initialized && !port.enabled) || (which == 4 && port.enabled);
    if (wanted) handles.push_back({number, static_cast<std::uint16_t>(bits(port.initialized, port.enabled))});
  }
  return encode_text(encode_handles(handles));
}

// Device, system, tool ('1': wireless), port, channel. Wired tools have their handles already.
std::string SimulatedDevice::request_handle(const std::string& parameters) {
  constexpr std::size_t kLetters = 14, kKind = 9;
  if (parameters.size() != kLetters) return encode_error(Code::wrong_parameters);
  if (parameters[kKind] != '1' && parameters[kKind] != '*') return encode_error(Code::out_of_range);
  for (std::uint8_t handle = 1; handle < kMostHandles; ++handle) {
    if (ports_.contains(handle)) continue;
    ports_[handle].wireless = true;
    return encode_text(fmt::format("{:02X}", handle));
  }
  return encode_error(Code::handles_full);
}

// Handle, place in the definition, 64 bytes.
std::string SimulatedDevice::write_definition(const std::string& parameters) {
  constexpr std::size_t kHandle = 2, kBefore = 6;
  std::uint32_t handle = 0, place = 0;
  const std::string_view text = parameters;
  if (text.size() != kBefore + 2 * kBlockBytes || !read_hex(text.substr(0, kHandle), handle) ||
      !read_hex(text.substr(kHandle, kBefore - kHandle), place))
    return encode_error(Code::wrong_parameters);
  const auto port = ports_.find(static_cast<std::uint8_t>(handle));
  if (port == ports_.end() || !port->second.wireless) return encode_error(Code::no_such_handle);
  if (place + kBlockBytes > Definition::kMostBytes) return encode_error(Code::out_of_range);
  auto& definition = port->second.definition;
  if (definition.size() < place + kBlockBytes) definition.resize(place + kBlockBytes, '\0');
  for (std::size_t i = 0; i < kBlockBytes; ++i) {
    std::uint32_t byte = 0;
    if (!read_hex(text.substr(kBefore + 2 * i, 2), byte)) return encode_error(Code::wrong_parameters);
    definition[place + i] = static_cast<char>(byte);
  }
  return encode_text("OKAY");
}

std::string SimulatedDevice::of_handle(const Command& command) {
  const std::string_view text = command.parameters;
  std::uint32_t number = 0;
  if (text.size() < 2 || !read_hex(text.substr(0, 2), number)) return encode_error(Code::wrong_parameters);
  const auto handle = static_cast<std::uint8_t>(number);
  const auto found = ports_.find(handle);
  if (found == ports_.end()) return encode_error(Code::no_such_handle);
  Port& port = found->second;
  const auto& name = command.name;
  if (name == "PHINF") return tool_info(handle, port, text.substr(2));
  if (name == "PHF") {
    ports_.erase(found);
  } else if (name == "PINIT") {
    if (port.wireless) {
      if (port.definition.empty()) return encode_error(Code::no_tool_definition);
      const auto wanted = part_number_in(port.definition);
      const auto tool = std::find_if(tools_.begin(), tools_.end(),
                                     [&](const auto& there) { return part_number(there) == wanted; });
      port.tool = tool == tools_.end() ? "" : *tool;
    }
    port.initialized = true;
  } else {
    if (!port.initialized) return encode_error(Code::not_initialized);
    const auto priority = text.substr(2);
    if (name == "PENA" && priority != "D" && priority != "S" && priority != "B")
      return encode_error(Code::no_such_priority);
    port.enabled = name == "PENA";
  }
  return encode_text("OKAY");
}

// 0001 what it is, 0004 its part number; of these, those that are asked for.
std::string SimulatedDevice::tool_info(std::uint8_t handle, const Port& port,
                                       std::string_view options) const {
  std::uint32_t wanted = 1;
  if (!options.empty() && !read_hex(options, wanted)) return encode_error(Code::wrong_parameters);
  if (wanted == 0 || (wanted & ~0x5u) != 0) return encode_error(Code::out_of_range);
  const auto whole = encode_tool_info(
      {.serial_number = fmt::format("{:08X}", handle),
       .part_number = port.wireless ? part_number_in(port.definition) : part_number(port.tool),
       .status = static_cast<std::uint8_t>(bits(port.initialized, port.enabled))});
  const auto basic = whole.size() - kPartNumberBytes;
  return encode_text(((wanted & 1) != 0 ? whole.substr(0, basic) : "") +
                     ((wanted & 4) != 0 ? whole.substr(basic) : ""));
}

bool SimulatedDevice::is_missing(const Port& port, std::int64_t now_ns) const {
  const auto newest = newest_.find(port.tool);
  return newest == newest_.end() || now_ns - newest->second.at_ns > kSeenNs;
}

// TX and BX: the newest pose of each tool. 0800, with those out of the volume, changes nothing: there are none.
std::string SimulatedDevice::newest(const Command& command, std::int64_t now_ns) const {
  std::uint32_t options = 1;
  if (!command.parameters.empty() && !read_hex(command.parameters, options))
    return encode_error(Code::wrong_parameters);
  if ((options & ~0x0800u) != 1) return encode_error(Code::out_of_range);
  std::vector<Reading> readings;
  for (const auto& [number, port] : ports_) {
    Reading& reading = readings.emplace_back();
    reading.handle = number;
    reading.status = bits(port.initialized, port.enabled);
    reading.frame = last_.frame;
    if (!port.enabled) continue;
    reading.state = is_missing(port, now_ns) ? Reading::State::missing : Reading::State::valid;
    if (reading.state != Reading::State::valid) continue;
    const auto& seen = newest_.at(port.tool);
    reading.pose = seen.pose;
    reading.frame = seen.frame;
  }
  return command.name == "TX" ? encode_text(encode_tx(readings)) : encode_binary(encode_bx(readings));
}

Frame SimulatedDevice::frame_of(const Sight& sight) const {
  Frame frame{Instant<TrackerClock>{Duration(sight.stamp_ns)}, sight.frame, {}};
  for (const auto& [number, port] : ports_)
    for (const auto& [tool, pose] : sight.tools)
      if (port.enabled && port.tool == tool)
        frame.tools.push_back(
            {.handle = number, .state = Reading::State::valid, .pose = pose, .frame = sight.frame});
  return frame;
}

// Those that have gone out of sight since it was asked for the last time, each told once.
Frame SimulatedDevice::missing_ones(std::int64_t now_ns) {
  Frame frame;
  for (auto& [number, port] : ports_) {
    const bool missing = port.enabled && is_missing(port, now_ns);
    if (missing && !port.told_missing)
      frame.tools.push_back(
          {.handle = number, .state = Reading::State::missing, .status = 0, .frame = last_.frame + 1});
    port.told_missing = missing;
  }
  if (frame.tools.empty()) return frame;
  // The device's clock has gone on since the last pose.
  last_ = {.frame = last_.frame + 1,
           .stamp_ns = last_.stamp_ns + std::max<std::int64_t>(now_ns - last_.at_ns, 0),
           .at_ns = now_ns,
           .tools = {}};
  if (last_.frame == 1) last_.stamp_ns = now_ns;
  frame.number = last_.frame;
  frame.stamp = Instant<TrackerClock>{Duration(last_.stamp_ns)};
  return frame;
}

std::string SimulatedDevice::since_last_asked(std::int64_t now_ns) {
  asked_ = true;
  std::vector<Frame> frames;
  std::size_t bytes = 0;
  for (; !sights_.empty(); sights_.pop_front()) {
    auto frame = frame_of(sights_.front());
    if (frame.tools.empty()) continue;
    bytes += bytes_of(frame);
    if (bytes > kMostReply && !frames.empty()) break;
    frames.push_back(std::move(frame));
  }
  if (frames.empty())
    if (auto missing = missing_ones(now_ns); !missing.tools.empty()) frames.push_back(std::move(missing));
  return encode_binary(encode_bx2(frames));
}

}  // namespace palpate::drivers::ndi
