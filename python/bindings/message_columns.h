// Messages of protobuf as columns, read by the description that a recording carries, without protobuf's own library: two
// copies of that in one process end it, and Python's may be there already.
//
// A field of a message within a message is called `tip_m.x`, one within a message that repeats `bodies.0.place_m.x`. A
// repeated number is one column with as many values in a row as its longest message has. What a message lacks is 0, false or
// an empty text, as protobuf has it; what a whole message within it, or an optional number, would hold is no number (NaN).
// Of bytes (pictures) the length counts. Wire format: https://protobuf.dev/programming-guides/encoding. Not for threads.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::python {

struct Column {
  enum class Kind { real, integer, whole, flag, text };
  Kind kind = Kind::real;
  bool repeated = false;
  bool absent_is_zero = true;
  // By its kind one of these: integer as it is, whole and flag too.
  std::vector<double> reals;
  std::vector<std::int64_t> integers;
  std::vector<std::string> texts;
  std::vector<std::size_t> ends;  // of a repeated one, of each row: where its values end

  std::size_t rows() const;
  void pad(std::size_t rows);  // what is absent, until there are so many
};

struct FieldType {
  std::string name, message;  // the message's full name, with a point in front, where it is one
  int type = 0;               // as descriptor.proto numbers them
  bool repeated = false, optional = false;
};
using MessageType = std::map<std::uint32_t, FieldType>;   // by the fields' numbers
using MessageTypes = std::map<std::string, MessageType>;  // by full names, with a point in front

// Refused where `descriptor_set`, a FileDescriptorSet, is none.
Expected<MessageTypes> message_types(std::string_view descriptor_set);

class MessageColumns {
 public:
  // `types` outlive it. Wrong use where they lack `message` ("palpate.recording.ArmSample").
  static Expected<MessageColumns> of(const MessageTypes& types, const std::string& message);
  MessageColumns(MessageColumns&&) noexcept;
  ~MessageColumns();

  // A row more. Refused where the bytes are no such message.
  Expected<void> add(std::string_view message);
  // All of the same length; called once, at the end.
  std::vector<std::pair<std::string, Column>> take();

 private:
  struct Node;
  explicit MessageColumns(const MessageTypes& types, std::unique_ptr<Node> root);
  Expected<void> read(Node& node, std::string_view bytes, int depth);
  Expected<void> read_field(Node& node, std::uint32_t number, const FieldType& field, int wire_type,
                            std::uint64_t value, std::string_view bytes, std::size_t occurrence, int depth);
  Column& column(Node& node, std::uint32_t number, const FieldType& field, std::size_t occurrence);

  const MessageTypes* types_;
  std::unique_ptr<Node> root_;
  std::vector<std::pair<std::string, Column>> columns_;
  std::size_t rows_ = 0;
};

}  // namespace palpate::python
