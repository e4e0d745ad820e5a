#include "python/bindings/message_columns.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace palpate::python {
namespace {

constexpr int kMostDepth = 12;            // of messages within messages
constexpr std::size_t kMostRepeats = 64;  // of a message within one; further ones are left out

enum Wire { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };
enum Type {
  kDouble = 1,
  kFloat,
  kInt64,
  kUint64,
  kInt32,
  kFixed64Type,
  kFixed32Type,
  kBool,
  kString,
  kGroup,
  kMessage,
  kBytesType,
  kUint32,
  kEnum,
  kSfixed32,
  kSfixed64,
  kSint32,
  kSint64
};

// Goes through the fields of a message.
class WireReader {
 public:
  explicit WireReader(std::string_view message) : rest_(message) {}

  std::uint32_t number = 0;
  int wire_type = 0;
  std::uint64_t value = 0;  // of a number, its bits
  std::string_view bytes;   // of all else

  // The next field; false at the end, and where it is none: sound() tells which.
  bool next() {
    if (rest_.empty() || !sound_) return false;
    const std::uint64_t key = varint();
    number = static_cast<std::uint32_t>(key >> 3);
    wire_type = static_cast<int>(key & 7);
    switch (wire_type) {
      case kVarint:
        value = varint();
        break;
      case kFixed64:
        value = fixed(8);
        break;
      case kFixed32:
        value = fixed(4);
        break;
      case kBytes:
        bytes = taken(varint());
        break;
      default:
        sound_ = false;
    }
    return sound_ && number != 0;
  }
  bool sound() const { return sound_; }
  bool empty() const { return rest_.empty(); }

  std::uint64_t varint() {
    std::uint64_t result = 0;
    for (unsigned shift = 0; shift < 64 && !rest_.empty(); shift += 7) {
      const auto byte = static_cast<unsigned char>(rest_.front());
      rest_.remove_prefix(1);
      result |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80) return result;
    }
    sound_ = false;
    return 0;
  }
  std::uint64_t fixed(std::size_t size) {
    const std::string_view part = taken(size);
    std::uint64_t result = 0;
    for (std::size_t i = 0; i < part.size(); ++i)
      result |= static_cast<std::uint64_t>(static_cast<unsigned char>(part[i])) << (8 * i);
    return result;
  }

 private:
  std::string_view taken(std::uint64_t size) {
    if (size > rest_.size()) {
      sound_ = false;
      return {};
    }
    const std::string_view part = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return part;
  }

  std::string_view rest_;
  bool sound_ = true;
};

// Of a FieldDescriptorProto; the field's number beside it.
std::pair<std::uint32_t, FieldType> field_of(std::string_view bytes, bool& sound) {
  FieldType field;
  std::uint32_t number = 0;
  WireReader reader(bytes);
  while (reader.next()) {
    if (reader.number == 1) field.name = reader.bytes;
    if (reader.number == 3) number = static_cast<std::uint32_t>(reader.value);
    if (reader.number == 4) field.repeated = reader.value == 3;
    if (reader.number == 5) field.type = static_cast<int>(reader.value);
    if (reader.number == 6) field.message = reader.bytes;
    if (reader.number == 17) field.optional = reader.value != 0;
  }
  sound = sound && reader.sound();
  return {number, field};
}

// Of a DescriptorProto, and the messages that are described within it.
void add_message(std::string_view bytes, const std::string& scope, MessageTypes& types, bool& sound,
                 int depth = 0) {
  std::string name;
  MessageType fields;
  std::vector<std::string_view> nested;
  WireReader reader(bytes);
  while (reader.next()) {
    if (reader.number == 1) name = reader.bytes;
    if (reader.number == 2) fields.insert(field_of(reader.bytes, sound));
    if (reader.number == 3) nested.push_back(reader.bytes);
  }
  sound = sound && reader.sound() && depth < kMostDepth;
  if (!sound) return;
  const std::string full = scope + "." + name;
  types[full] = std::move(fields);
  for (const auto inner : nested) add_message(inner, full, types, sound, depth + 1);
}

void add_file(std::string_view bytes, MessageTypes& types, bool& sound) {
  std::string package;
  std::vector<std::string_view> messages;
  WireReader reader(bytes);
  while (reader.next()) {
    if (reader.number == 2) package = reader.bytes;
    if (reader.number == 4) messages.push_back(reader.bytes);
  }
  sound = sound && reader.sound();
  const std::string scope = package.empty() ? "" : "." + package;
  for (const auto message : messages) add_message(message, scope, types, sound);
}

Column::Kind kind_of(int type) {
  switch (type) {
    case kDouble:
    case kFloat:
      return Column::Kind::real;
    case kBool:
      return Column::Kind::flag;
    case kString:
      return Column::Kind::text;
    case kUint64:
    case kUint32:
    case kFixed64Type:
    case kFixed32Type:
    case kBytesType:
      return Column::Kind::whole;
    default:
      return Column::Kind::integer;
  }
}

int wire_type_of(int type) {
  switch (type) {
    case kDouble:
    case kFixed64Type:
    case kSfixed64:
      return kFixed64;
    case kFloat:
    case kFixed32Type:
    case kSfixed32:
      return kFixed32;
    case kString:
    case kBytesType:
    case kMessage:
      return kBytes;
    default:
      return kVarint;
  }
}

std::int64_t unzigzagged(std::uint64_t value) {
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

// A number by its bits.
void put(Column& column, int type, std::uint64_t value) {
  switch (type) {
    case kDouble:
      column.reals.push_back(std::bit_cast<double>(value));
      break;
    case kFloat:
      column.reals.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(value)));
      break;
    case kBool:
      column.integers.push_back(value != 0);
      break;
    case kSint32:
    case kSint64:
      column.integers.push_back(unzigzagged(value));
      break;
    case kInt32:
    case kEnum:
    case kSfixed32:
      column.integers.push_back(static_cast<std::int32_t>(value));
      break;
    default:
      column.integers.push_back(static_cast<std::int64_t>(value));
  }
}

}  // namespace

std::size_t Column::rows() const {
  if (repeated) return ends.size();
  return kind == Kind::real ? reals.size() : kind == Kind::text ? texts.size() : integers.size();
}

void Column::pad(std::size_t rows) {
  if (repeated) {
    ends.resize(std::max(rows, ends.size()), ends.empty() ? 0 : ends.back());
    return;
  }
  if (rows <= this->rows()) return;
  if (kind == Kind::real)
    reals.resize(rows, absent_is_zero ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  else if (kind == Kind::text)
    texts.resize(rows);
  else
    integers.resize(rows, 0);
}

// A message within the one that is read: its columns, and the messages within it, by field and occurrence.
struct MessageColumns::Node {
  const MessageType* type = nullptr;
  std::string prefix;  // "tip_m."
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> columns;
  std::map<std::pair<std::uint32_t, std::size_t>, std::unique_ptr<Node>> nodes;
};

Expected<MessageTypes> message_types(std::string_view descriptor_set) {
  MessageTypes types;
  bool sound = true;
  WireReader reader(descriptor_set);
  while (reader.next())
    if (reader.number == 1) add_file(reader.bytes, types, sound);
  if (!sound || !reader.sound()) return refused("the description of the messages is damaged");
  return types;
}

MessageColumns::MessageColumns(const MessageTypes& types, std::unique_ptr<Node> root)
    : types_(&types), root_(std::move(root)) {}
MessageColumns::MessageColumns(MessageColumns&&) noexcept = default;
MessageColumns::~MessageColumns() = default;

Expected<MessageColumns> MessageColumns::of(const MessageTypes& types, const std::string& message) {
  const auto type = types.find("." + message);
  if (type == types.end()) return wrong_use("no message '{}' is described", message);
  auto root = std::make_unique<Node>();
  root->type = &type->second;
  MessageColumns columns(types, std::move(root));
  // What every message may hold is a column even where none does.
  for (const auto& [number, field] : type->second)
    if (field.type != kMessage && field.type != kGroup) columns.column(*columns.root_, number, field, 0);
  return columns;
}

Column& MessageColumns::column(Node& node, std::uint32_t number, const FieldType& field,
                               std::size_t occurrence) {
  // A word that repeats has a column for each; of numbers that do one column holds all.
  const bool each = field.repeated && wire_type_of(field.type) == kBytes;
  const auto key = std::pair(number, each ? occurrence : 0);
  auto at = node.columns.find(key);
  if (at == node.columns.end()) {
    Column column;
    column.kind = kind_of(field.type);
    column.repeated = field.repeated && !each;
    column.absent_is_zero = &node == root_.get() && !field.optional;
    columns_.emplace_back(node.prefix + field.name + (each ? fmt::format(".{}", occurrence) : ""),
                          std::move(column));
    at = node.columns.emplace(key, columns_.size() - 1).first;
  }
  return columns_[at->second].second;
}

Expected<void> MessageColumns::read_field(Node& node, std::uint32_t number, const FieldType& field,
                                          int wire_type, std::uint64_t value, std::string_view bytes,
                                          std::size_t occurrence, int depth) {
  if (field.type == kMessage) {
    if (wire_type != kBytes || depth >= kMostDepth) return refused("a message holds what it cannot");
    if (occurrence >= kMostRepeats) return {};
    auto& inner = node.nodes[{number, field.repeated ? occurrence : 0}];
    if (!inner) {
      const auto type = types_->find(field.message);
      if (type == types_->end()) return refused("the message '{}' is not described", field.message);
      inner = std::make_unique<Node>();
      inner->type = &type->second;
      inner->prefix = node.prefix + field.name + (field.repeated ? fmt::format(".{}.", occurrence) : ".");
    }
    return read(*inner, bytes, depth + 1);
  }
  const bool packed = field.repeated && wire_type == kBytes && wire_type_of(field.type) != kBytes;
  if (!packed && wire_type != wire_type_of(field.type))
    return refused("a field has another type than is described");
  if (occurrence >= kMostRepeats && wire_type_of(field.type) == kBytes) return {};
  Column& to = column(node, number, field, occurrence);
  to.pad(rows_);
  if (!to.repeated && to.rows() > rows_)  // said twice: the last counts
    to.kind == Column::Kind::real   ? to.reals.pop_back()
    : to.kind == Column::Kind::text ? to.texts.pop_back()
                                    : to.integers.pop_back();
  if (packed) {
    WireReader values(bytes);
    while (!values.empty() && values.sound())
      put(to, field.type,
          wire_type_of(field.type) == kVarint ? values.varint()
                                              : values.fixed(wire_type_of(field.type) == kFixed64 ? 8 : 4));
    if (!values.sound()) return refused("a list of numbers is cut off");
  } else if (field.type == kString) {
    to.texts.emplace_back(bytes);
  } else if (field.type == kBytesType) {
    to.integers.push_back(static_cast<std::int64_t>(bytes.size()));
  } else {
    put(to, field.type, value);
  }
  if (!to.repeated) return {};
  const std::size_t end = to.kind == Column::Kind::real ? to.reals.size() : to.integers.size();
  if (to.ends.size() > rows_)
    to.ends.back() = end;
  else
    to.ends.push_back(end);
  return {};
}

Expected<void> MessageColumns::read(Node& node, std::string_view bytes, int depth) {
  std::map<std::uint32_t, std::size_t> occurrences;
  // What a message that is there lacks is 0, in a column that a further message may bring.
  for (const auto& [number, field] : *node.type)
    if (field.type != kMessage && field.type != kGroup && !field.repeated && !field.optional) {
      Column& to = column(node, number, field, 0);
      to.pad(rows_);
      if (to.rows() > rows_) continue;
      const bool zero = to.absent_is_zero;
      to.absent_is_zero = true;
      to.pad(rows_ + 1);
      to.absent_is_zero = zero;
    }
  WireReader reader(bytes);
  while (reader.next()) {
    const auto field = node.type->find(reader.number);
    if (field == node.type->end() || field->second.type == kGroup) continue;
    const std::size_t occurrence = field->second.repeated ? occurrences[reader.number]++ : 0;
    if (auto done = read_field(node, reader.number, field->second, reader.wire_type, reader.value,
                               reader.bytes, occurrence, depth);
        !done)
      return done;
  }
  if (!reader.sound()) return refused("a message is cut off");
  return {};
}

Expected<void> MessageColumns::add(std::string_view message) {
  auto done = read(*root_, message, 0);
  ++rows_;
  for (auto& column : columns_) column.second.pad(rows_);
  return done;
}

std::vector<std::pair<std::string, Column>> MessageColumns::take() {
  for (auto& column : columns_) column.second.pad(rows_);
  return std::move(columns_);
}

}  // namespace palpate::python
