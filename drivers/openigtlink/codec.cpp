#include "drivers/openigtlink/codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/pose_file.h"

namespace palpate::drivers::openigtlink {
namespace {

constexpr std::size_t kTypeBytes = 12, kCoordinatesBytes = 32;
constexpr std::size_t kTransformBytes = 48, kToolBytes = 70, kStatusBytes = 30, kStartBytes = 36;
constexpr std::size_t kExtensionBytes = 12;  // what is read of the extended header; it may be longer

constexpr std::array<std::uint64_t, 256> make_crc_table() {
  constexpr std::uint64_t kPolynomial = 0x42F0E1EBA9EA3693ull;
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t byte = 0; byte < 256; ++byte) {
    std::uint64_t rest = byte << 56;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 63) != 0 ? (rest << 1) ^ kPolynomial : rest << 1;
    table[byte] = rest;
  }
  return table;
}
constexpr auto kCrcTable = make_crc_table();

// Big-endian numbers and padded texts, front to back. The caller has checked that there are enough bytes.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  std::string_view take(std::size_t count) {
    const auto taken = bytes_.substr(0, count);
    bytes_.remove_prefix(taken.size());
    return taken;
  }
  template <typename T>
  T number() {
    T value = 0;
    for (const char c : take(sizeof(T)))
      value = static_cast<T>((value << (sizeof(T) > 1 ? 8 : 0)) | static_cast<unsigned char>(c));
    return value;
  }
  double real() { return static_cast<double>(std::bit_cast<float>(number<std::uint32_t>())); }
  // Up to the first 0; control characters become '?', since names end up in terminals and messages.
  std::string text(std::size_t count) {
    const auto field = take(count);
    return excerpt(field.substr(0, field.find('\0')), count);
  }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

class Writer {
 public:
  template <typename T>
  void number(T value) {
    for (int shift = 8 * (static_cast<int>(sizeof(T)) - 1); shift >= 0; shift -= 8)
      bytes.push_back(static_cast<char>(static_cast<unsigned char>(value >> shift)));
  }
  void real(double value) { number(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void text(std::string_view value, std::size_t count) {
    value = value.substr(0, std::min(count, value.find('\0')));
    bytes.append(value).append(count - value.size(), '\0');
  }
  std::string bytes;
};

Expected<RigidPose> read_pose(Reader& reader, const std::string& where) {
  double columns[12], rows[12];
  for (double& value : columns) value = reader.real();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) rows[4 * r + c] = columns[3 * c + r];
  const auto pose = device::pose_from_matrix(rows, 1.0 / kMillimetresPerMetre, where);
  if (!pose) return refused("{}", pose.error().message);
  return RigidPose{pose->rotation, pose->translation};
}

Expected<void> write_pose(Writer& writer, const RigidPose& pose, std::string_view name) {
  if (!(std::abs(pose.rotation.norm() - 1.0) < 1e-6) || !pose.translation.allFinite() ||
      pose.translation.cwiseAbs().maxCoeff() > kFarthestPlace)
    return refused("{}: the pose to send is not rigid or not within {:g} m; a unit quaternion is expected",
                   excerpt(name), kFarthestPlace);
  const Matrix3 R = pose.rotation.toRotationMatrix();
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) writer.real(R(r, c));
  for (int r = 0; r < 3; ++r) writer.real(mm_from_metres(pose.translation[r]));
  return {};
}

struct Parts {
  std::string_view content, metadata_header, metadata;
};

// A later header's body: extended header, content, metadata header, metadata. Earlier ones are content.
Expected<Parts> split_body(const Header& header, std::string_view body, const std::string& where) {
  if (header.version < 2) return Parts{body, {}, {}};
  Reader reader(body);
  std::uint64_t extension = 0, metadata_header = 0, metadata = 0;
  if (body.size() >= kExtensionBytes) {
    extension = reader.number<std::uint16_t>();
    metadata_header = reader.number<std::uint16_t>();
    metadata = reader.number<std::uint32_t>();
  }
  if (extension < kExtensionBytes || extension + metadata_header + metadata > body.size())
    return refused(
        "{}: extended header of {} bytes and metadata of {} do not fit a body of {}; at least {} "
        "and at most the body's are expected",
        where, extension, metadata_header + metadata, body.size(), kExtensionBytes);
  Parts parts;
  const std::size_t content = body.size() - static_cast<std::size_t>(extension + metadata_header + metadata);
  parts.content = body.substr(static_cast<std::size_t>(extension), content);
  body.remove_prefix(static_cast<std::size_t>(extension) + content);
  parts.metadata_header = body.substr(0, static_cast<std::size_t>(metadata_header));
  parts.metadata = body.substr(static_cast<std::size_t>(metadata_header));
  return parts;
}

// A value of the metadata; none where it is not there or the metadata is broken, which is not ours to judge.
std::optional<std::string_view> find_metadata(const Parts& parts, std::string_view key) {
  if (parts.metadata_header.size() < 2) return std::nullopt;
  Reader entries(parts.metadata_header), texts(parts.metadata);
  constexpr std::size_t kEntryBytes = 8;  // key's size, encoding, value's size
  std::size_t count = entries.number<std::uint16_t>();
  count = std::min(count, entries.rest().size() / kEntryBytes);
  for (; count > 0; --count) {
    const std::size_t key_bytes = entries.number<std::uint16_t>();
    entries.take(2);
    const std::size_t value_bytes = entries.number<std::uint32_t>();
    if (texts.rest().size() < key_bytes || texts.rest().size() - key_bytes < value_bytes) return std::nullopt;
    const auto name = texts.take(key_bytes);
    const auto value = texts.take(value_bytes);
    if (name == key) return value;
  }
  return std::nullopt;
}

tl::unexpected<Error> wrong_length(const std::string& where, std::size_t bytes, std::string_view expected) {
  return refused("{}: a content of {} bytes; {} are expected", where, bytes, expected);
}

Expected<Content> read_transform(const Parts& parts, const std::string& where) {
  if (parts.content.size() != kTransformBytes) return wrong_length(where, parts.content.size(), "48");
  Transform transform;
  // The word of PLUS and 3D Slicer, which go on sending a pose while the tool is out of sight.
  const auto status = find_metadata(parts, "TransformStatus");
  transform.valid = !status || *status == "OK";
  Reader reader(parts.content);
  auto pose = read_pose(reader, where);
  if (!pose && transform.valid) return tl::unexpected(pose.error());
  if (pose) transform.pose = *pose;
  return transform;
}

Expected<Content> read_tracking_data(const Parts& parts, const std::string& where) {
  const std::size_t bytes = parts.content.size();
  if (bytes % kToolBytes != 0) return wrong_length(where, bytes, "70 for each tool");
  Reader reader(parts.content);
  TrackingData data;
  data.tools.resize(bytes / kToolBytes);
  for (auto& tool : data.tools) {
    tool.name = reader.text(kNameBytes);
    tool.type = reader.number<std::uint8_t>();
    reader.take(1);
    auto pose = read_pose(reader, where);
    if (!pose) return tl::unexpected(pose.error());
    tool.pose = *pose;
  }
  return data;
}

Expected<Content> read_status(const Parts& parts, const std::string& where) {
  if (parts.content.size() < kStatusBytes) return wrong_length(where, parts.content.size(), "at least 30");
  Reader reader(parts.content);
  Status status;
  status.code = reader.number<std::uint16_t>();
  status.subcode = static_cast<std::int64_t>(reader.number<std::uint64_t>());
  status.name = reader.text(kNameBytes);
  status.text = reader.text(reader.rest().size());
  return status;
}

Expected<Content> read_start(const Parts& parts, const std::string& where) {
  if (parts.content.size() != kStartBytes) return wrong_length(where, parts.content.size(), "36");
  Reader reader(parts.content);
  StartTracking start;
  start.resolution_ms = static_cast<std::int32_t>(reader.number<std::uint32_t>());
  start.coordinates = reader.text(kCoordinatesBytes);
  return start;
}

Expected<Content> read_stop(const Parts&, const std::string&) { return StopTracking{}; }

struct Kind {
  std::string_view type;
  Expected<Content> (*read)(const Parts&, const std::string& where);
};
// In the order of Content's alternatives.
constexpr Kind kKinds[] = {{"TRANSFORM", read_transform},
                           {"TDATA", read_tracking_data},
                           {"STATUS", read_status},
                           {"STT_TDATA", read_start},
                           {"STP_TDATA", read_stop}};

const Kind* find_kind(std::string_view type) {
  const auto* at =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return k.type == type; });
  return at == std::end(kKinds) ? nullptr : at;
}

struct BodyWriter {
  Writer& writer;
  const std::string& device;

  Expected<void> operator()(const Transform& transform) const {
    return write_pose(writer, transform.pose, device);
  }
  Expected<void> operator()(const TrackingData& data) const {
    if (data.tools.size() > kMostBodyBytes / kToolBytes)
      return refused("{}: {} tools in one message; at most {} are expected", excerpt(device),
                     data.tools.size(), kMostBodyBytes / kToolBytes);
    for (const auto& tool : data.tools) {
      writer.text(tool.name, kNameBytes);
      writer.number(tool.type);
      writer.number(std::uint8_t{0});
      if (auto written = write_pose(writer, tool.pose, tool.name); !written) return written;
    }
    return {};
  }
  Expected<void> operator()(const Status& status) const {
    if (status.text.size() > kMostBodyBytes - kStatusBytes)
      return refused("{}: a status text of {} bytes; at most {} are expected", excerpt(device),
                     status.text.size(), kMostBodyBytes - kStatusBytes);
    writer.number(status.code);
    writer.number(static_cast<std::uint64_t>(status.subcode));
    writer.text(status.name, kNameBytes);
    // Ends in a 0 where there is room for one.
    writer.text(status.text, std::min(status.text.size() + 1, kMostBodyBytes - kStatusBytes));
    return {};
  }
  Expected<void> operator()(const StartTracking& start) const {
    writer.number(static_cast<std::uint32_t>(start.resolution_ms));
    writer.text(start.coordinates, kCoordinatesBytes);
    return {};
  }
  Expected<void> operator()(const StopTracking&) const { return {}; }
};

}  // namespace

std::uint64_t crc64(std::string_view bytes) {
  std::uint64_t crc = 0;
  for (const char c : bytes) crc = (crc << 8) ^ kCrcTable[(crc >> 56) ^ static_cast<unsigned char>(c)];
  return crc;
}

std::optional<Instant<TrackerClock>> stamp_from_wire(std::uint64_t fixed) {
  if (fixed == 0) return std::nullopt;
  const std::uint64_t whole = fixed >> 32, fraction = fixed & 0xFFFFFFFFull;
  // To the nearest, but never up into a second that the protocol may no longer have.
  const auto ns = std::min<std::uint64_t>((fraction * 1'000'000'000ull + (1ull << 31)) >> 32, 999'999'999);
  return Instant<TrackerClock>{Duration(static_cast<std::int64_t>(whole * 1'000'000'000ull + ns))};
}

Expected<std::uint64_t> wire_from_stamp(std::optional<Instant<TrackerClock>> stamp) {
  if (!stamp) return std::uint64_t{0};
  const std::int64_t ns = stamp->ns();
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  if (ns < 0 || ns / kNanoseconds >= std::int64_t{1} << 32)
    return refused("the time {} s is none of the protocol's; 0 to 4294967295 s are expected",
                   stamp->seconds());
  const auto whole = static_cast<std::uint64_t>(ns / kNanoseconds);
  const auto rest = static_cast<std::uint64_t>(ns % kNanoseconds);
  // Half a nanosecond is two units of the fraction: rounding never carries into the seconds.
  const std::uint64_t fraction = ((rest << 32) + kNanoseconds / 2) / kNanoseconds;
  return std::max<std::uint64_t>((whole << 32) | fraction, 1);
}

Expected<Header> decode_header(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes)
    return refused("a header of {} bytes; {} are expected", bytes.size(), kHeaderBytes);
  Reader reader(bytes);
  Header header;
  header.version = reader.number<std::uint16_t>();
  if (header.version < 1 || header.version > 3)
    return refused("not OpenIGTLink: header version {}; 1 to 3 are expected", header.version);
  const auto type = reader.take(kTypeBytes);
  header.type = std::string(type.substr(0, type.find('\0')));
  if (header.type.empty() ||
      !std::all_of(header.type.begin(), header.type.end(), [](char c) { return c > ' ' && c < 127; }))
    return refused("not OpenIGTLink: message type '{}'; a word of up to {} letters is expected",
                   excerpt(header.type), kTypeBytes);
  header.device = reader.text(kNameBytes);
  header.stamp = stamp_from_wire(reader.number<std::uint64_t>());
  header.body_bytes = reader.number<std::uint64_t>();
  header.crc = reader.number<std::uint64_t>();
  return header;
}

bool is_known(const Header& header) { return find_kind(header.type) != nullptr; }

bool crc_agrees(const Header& header, std::string_view body) { return crc64(body) == header.crc; }

Expected<Message> decode_body(const Header& header, std::string_view body) {
  const std::string where = fmt::format("{} of '{}'", header.type, header.device);
  const Kind* kind = find_kind(header.type);
  if (kind == nullptr) return refused("{}: a kind that is not read; TRANSFORM or TDATA is expected", where);
  if (header.body_bytes > kMostBodyBytes || body.size() != header.body_bytes)
    return refused("{}: {} bytes of a body of {}; all of them, and at most {}, are expected", where,
                   body.size(), header.body_bytes, kMostBodyBytes);
  if (!crc_agrees(header, body))
    return refused("{}: the CRC of the body is not the one in the header; an undamaged message is expected",
                   where);
  const auto parts = split_body(header, body, where);
  if (!parts) return tl::unexpected(parts.error());
  auto content = kind->read(*parts, where);
  if (!content) return tl::unexpected(content.error());
  return Message{header.device, header.stamp, std::move(*content)};
}

Expected<std::string> encode(const Message& message) {
  const auto stamp = wire_from_stamp(message.stamp);
  if (!stamp) return refused("{}: {}", excerpt(message.device), stamp.error().message);
  Writer body;
  const BodyWriter write{body, message.device};
  if (auto written = std::visit(write, message.content); !written) return tl::unexpected(written.error());
  Writer header;
  header.number(std::uint16_t{1});
  header.text(kKinds[message.content.index()].type, kTypeBytes);
  header.text(message.device, kNameBytes);
  header.number(*stamp);
  header.number(std::uint64_t{body.bytes.size()});
  header.number(crc64(body.bytes));
  return header.bytes + body.bytes;
}

}  // namespace palpate::drivers::openigtlink
