// Poses: TX, BX, BX2, and the frame around binary replies.
#include <algorithm>
#include <bit>
#include <cmath>

#include "drivers/ndi/codec.h"
#include "drivers/ndi/internal/limits.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::drivers::ndi {
namespace {

constexpr double kUnitWithin = 0.02;  // of a quaternion's length
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::uint16_t kShortStart = 0xa5c4, kLongStart = 0xa5c8;

// States of BX.
constexpr std::uint8_t kValid = 1, kMissing = 2, kDisabled = 4;
// Of the General Binary Format.
constexpr std::uint16_t kVersion = 1, kFrameComponent = 1, kPoseComponent = 2;
constexpr std::size_t kContainerBytes = 4, kComponentBytes = 12, kFrameBytes = 16, kHeadBytes = 4,
                      kPoseBytes = 32;

// Little endian; what is asked for beyond the end reads as 0 and makes the reader no good.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  template <typename Number>
  Number number() {
    const auto bytes = take(sizeof(Number));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
    return static_cast<Number>(value);
  }
  double real() { return double{std::bit_cast<float>(number<std::uint32_t>())}; }
  std::string_view take(std::size_t count) {
    good_ = good_ && count <= rest_.size();
    if (!good_) return {};
    const auto bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }
  bool good() const { return good_; }
  bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
  bool good_ = true;
};

class Writer {
 public:
  template <typename Number>
  void number(Number value) {
    for (std::size_t i = 0; i < sizeof(Number); ++i)
      bytes_ += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff);
  }
  void real(double value) { number(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void text(std::string_view text) { bytes_ += text; }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Quaternion, millimetres, error of the fit.
Expected<network::RigidPose> read_pose(Reader& reader) {
  const double w = reader.real(), x = reader.real(), y = reader.real(), z = reader.real();
  const double tx = reader.real(), ty = reader.real(), tz = reader.real();
  static_cast<void>(reader.real());
  if (!reader.good()) return refused("a reply that ends within a pose; {} bytes are expected", kPoseBytes);
  network::RigidPose pose;
  const Quaternion q(w, x, y, z);
  pose.translation = Vector3(metres_from_mm(tx), metres_from_mm(ty), metres_from_mm(tz));
  if (!pose.translation.allFinite() || !q.coeffs().allFinite() ||
      pose.translation.cwiseAbs().maxCoeff() > kFarthest)
    return refused("a pose that is no place; three numbers within {} m are expected", kFarthest);
  if (!(std::abs(q.norm() - 1.0) <= kUnitWithin))
    return refused("a pose whose quaternion has length {:.3g}; 1 is expected", q.norm());
  pose.rotation = q.normalized();
  return pose;
}

void write_pose(const network::RigidPose& pose, Writer& writer) {
  const auto& q = pose.rotation;
  for (const double number : {q.w(), q.x(), q.y(), q.z()}) writer.real(number);
  for (int i = 0; i < 3; ++i) writer.real(mm_from_metres(pose.translation[i]));
  writer.real(0.0);
}

// One component of a container, its items unread.
struct Component {
  std::uint16_t type = 0;
  std::uint32_t count = 0;
  Reader items;
};

Expected<Component> read_component(Reader& reader) {
  const auto type = reader.number<std::uint16_t>();
  const auto size = reader.number<std::uint32_t>();
  static_cast<void>(reader.number<std::uint16_t>());  // what is in its items: as its type says
  const auto count = reader.number<std::uint32_t>();
  const auto items = reader.take(size >= kComponentBytes ? size - kComponentBytes : 0);
  if (!reader.good() || size < kComponentBytes)
    return refused("a component of {} bytes; at least {} and at most what follows are expected", size,
                   kComponentBytes);
  return Component{type, count, Reader(items)};
}

Expected<void> read_tools(Component component, Frame& frame) {
  for (std::uint32_t i = 0; i < component.count; ++i) {
    auto& items = component.items;
    Reading reading;
    reading.handle = items.number<std::uint16_t>();
    reading.status = items.number<std::uint16_t>();
    reading.frame = frame.number;
    if (!items.good())
      return refused("{} tools in a frame that holds {}; all are expected", component.count, i);
    reading.state = (reading.status & kFrameMissing) != 0 ? Reading::State::missing : Reading::State::valid;
    reading.status &= 0xff;
    if (reading.state == Reading::State::valid) {
      auto pose = read_pose(items);
      if (!pose) return tl::unexpected(pose.error());
      reading.pose = *pose;
    }
    frame.tools.push_back(reading);
  }
  return {};
}

Expected<Frame> read_frame(Reader& items) {
  Frame frame;
  static_cast<void>(items.number<std::uint32_t>());  // what took it, a count, its state
  frame.number = items.number<std::uint32_t>();
  const auto seconds = items.number<std::uint32_t>(), nanoseconds = items.number<std::uint32_t>();
  static_cast<void>(items.number<std::uint16_t>());  // version
  const auto count = items.number<std::uint16_t>();
  if (!items.good())
    return refused("a frame that ends early; {} bytes are expected", kFrameBytes + kContainerBytes);
  if (nanoseconds >= kSecond)
    return refused("a frame's time of {} ns beside its seconds; less is expected", nanoseconds);
  frame.stamp = Instant<TrackerClock>{Duration(seconds * kSecond + nanoseconds)};
  for (int i = 0; i < count; ++i) {
    auto component = read_component(items);
    if (!component) return tl::unexpected(component.error());
    if (component->type != kPoseComponent) continue;
    if (const auto read = read_tools(*component, frame); !read) return tl::unexpected(read.error());
  }
  return frame;
}

std::uint16_t code_in_frame(const Reading& reading) {
  const auto code = static_cast<std::uint16_t>(reading.status & 0xff);
  return reading.state == Reading::State::valid ? code : static_cast<std::uint16_t>(code | kFrameMissing);
}

// Sign, digits; false where the number does not fit.
bool put_column(double number, double per_unit, int digits, std::string& text) {
  const double scaled = std::round(number * per_unit);
  if (!(std::abs(scaled) < std::pow(10.0, digits))) return false;
  text += fmt::format("{}{:0{}}", scaled < 0.0 ? '-' : '+', std::llround(std::abs(scaled)), digits);
  return true;
}

// Empty where a number does not fit its column.
std::string pose_columns(const network::RigidPose& pose) {
  constexpr double kPerUnit = 1e4, kPerMillimetre = 100.0;
  constexpr int kUnitDigits = 5, kPlaceDigits = 6;
  const auto& q = pose.rotation;
  std::string text;
  bool fits = true;
  for (const double number : {q.w(), q.x(), q.y(), q.z()})
    fits = fits && put_column(number, kPerUnit, kUnitDigits, text);
  for (int i = 0; i < 3; ++i)
    fits = fits && put_column(mm_from_metres(pose.translation[i]), kPerMillimetre, kPlaceDigits, text);
  return fits && put_column(0.0, kPerUnit, kUnitDigits, text) ? text : "";
}

}  // namespace

std::string encode_binary(std::string_view body) {
  Writer header, reply;
  if (body.size() <= 0xffff) {
    header.number(kShortStart);
    header.number(static_cast<std::uint16_t>(body.size()));
  } else {
    header.number(kLongStart);
    header.number(static_cast<std::uint32_t>(body.size()));
  }
  const auto bytes = header.take();
  reply.text(bytes);
  reply.number(checksum(bytes));
  reply.text(body);
  reply.number(checksum(body));
  return reply.take();
}

Expected<std::vector<Reading>> decode_bx(std::string_view body) {
  Reader reader(body);
  const auto count = reader.number<std::uint8_t>();
  std::vector<Reading> readings(count);
  for (auto& reading : readings) {
    reading.handle = reader.number<std::uint8_t>();
    const auto state = reader.number<std::uint8_t>();
    if (!reader.good()) return refused("{} handles in a reply that holds fewer; all are expected", count);
    if (state == kDisabled) continue;
    if (state != kValid && state != kMissing)
      return refused("a handle in state {}; {}, {} or {} is expected", state, kValid, kMissing, kDisabled);
    reading.state = state == kValid ? Reading::State::valid : Reading::State::missing;
    if (state == kValid) {
      auto pose = read_pose(reader);
      if (!pose) return tl::unexpected(pose.error());
      reading.pose = *pose;
    }
    reading.status = reader.number<std::uint32_t>();
    reading.frame = reader.number<std::uint32_t>();
  }
  static_cast<void>(reader.number<std::uint16_t>());  // of the whole device
  if (!reader.good() || !reader.at_end())
    return refused("a reply of {} bytes for {} handles; what they need is expected", body.size(), count);
  return readings;
}

std::string encode_bx(const std::vector<Reading>& readings) {
  Writer writer;
  writer.number(static_cast<std::uint8_t>(readings.size()));
  for (const auto& reading : readings) {
    writer.number(static_cast<std::uint8_t>(reading.handle));
    writer.number(reading.state == Reading::State::valid     ? kValid
                  : reading.state == Reading::State::missing ? kMissing
                                                             : kDisabled);
    if (reading.state == Reading::State::disabled) continue;
    if (reading.state == Reading::State::valid) write_pose(reading.pose, writer);
    writer.number(reading.status);
    writer.number(reading.frame);
  }
  writer.number(std::uint16_t{0});
  return writer.take();
}

std::string encode_tx(const std::vector<Reading>& readings) {
  std::string text = fmt::format("{:02X}", readings.size());
  for (const auto& reading : readings) {
    text += fmt::format("{:02X}", reading.handle);
    if (reading.state == Reading::State::disabled) {
      text += "DISABLED";
    } else {
      const auto columns = reading.state == Reading::State::valid ? pose_columns(reading.pose) : "";
      text += columns.empty() ? "MISSING" : columns;
    }
    text += fmt::format("{:08X}{:08X}\n", reading.status, reading.frame);
  }
  return text + "0000";
}

Expected<std::vector<Frame>> decode_bx2(std::string_view body) {
  Reader reader(body);
  static_cast<void>(reader.number<std::uint16_t>());  // version
  const auto count = reader.number<std::uint16_t>();
  if (!reader.good())
    return refused("a reply of {} bytes; at least {} are expected", body.size(), kContainerBytes);
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    auto component = read_component(reader);
    if (!component) return tl::unexpected(component.error());
    if (component->type != kFrameComponent) continue;
    for (std::uint32_t item = 0; item < component->count; ++item) {
      auto frame = read_frame(component->items);
      if (!frame) return tl::unexpected(frame.error());
      frames.push_back(std::move(*frame));
    }
  }
  if (!reader.at_end())
    return refused("a reply of {} bytes for {} components; what they need is expected", body.size(), count);
  return frames;
}

std::size_t bytes_of(const Frame& frame) {
  std::size_t bytes = kComponentBytes + kFrameBytes + kContainerBytes + kComponentBytes;
  for (const auto& reading : frame.tools)
    bytes += kHeadBytes + (reading.state == Reading::State::valid ? kPoseBytes : 0);
  return bytes;
}

std::string encode_bx2(const std::vector<Frame>& frames) {
  constexpr std::uint16_t kPassive = 2;  // with 0 for the frame's place in a sequence
  Writer writer;
  const auto begin_component = [&](std::uint16_t type, std::size_t bytes, std::size_t count) {
    writer.number(type);
    writer.number(static_cast<std::uint32_t>(bytes));
    writer.number(std::uint16_t{0});
    writer.number(static_cast<std::uint32_t>(count));
  };
  writer.number(kVersion);
  writer.number(static_cast<std::uint16_t>(frames.size()));
  for (const auto& frame : frames) {
    begin_component(kFrameComponent, bytes_of(frame), 1);
    writer.number(kPassive);
    writer.number(std::uint16_t{0});
    writer.number(frame.number);
    writer.number(static_cast<std::uint32_t>(frame.stamp.ns() / kSecond));
    writer.number(static_cast<std::uint32_t>(frame.stamp.ns() % kSecond));
    writer.number(kVersion);
    writer.number(std::uint16_t{1});
    begin_component(kPoseComponent, bytes_of(frame) - kComponentBytes - kFrameBytes - kContainerBytes,
                    frame.tools.size());
    for (const auto& reading : frame.tools) {
      writer.number(reading.handle);
      writer.number(code_in_frame(reading));
      if (reading.state == Reading::State::valid) write_pose(reading.pose, writer);
    }
  }
  return writer.take();
}

}  // namespace palpate::drivers::ndi
