// A protobuf message of any type as columns: which there are shows in all messages of a topic. The type comes from the recording's
// own schema, so messages of others are read, too. Private to the module.
#pragma once

#include <google/protobuf/dynamic_message.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/record/mcap.h"

namespace palpate::record::session {

class FlatMessage {
 public:
  // Refused where the schema is none of protobuf, or names a type it does not hold.
  static Expected<FlatMessage> of(const Schema& schema);

  // First every message: false where it is none.
  bool measure(std::string_view bytes);
  // Then the columns, and of every message again its cells, as many.
  std::vector<std::string> columns() const;
  std::vector<std::string> cells(std::string_view bytes) const;

 private:
  using Message = google::protobuf::Message;
  using Field = google::protobuf::FieldDescriptor;
  static constexpr int kMostRepeats = 64, kDeepest = 6;

  FlatMessage() = default;
  void measure(const Message& message, const std::string& path, int depth);
  // `visit(name, message or null, field, index or -1)` of every column, in their order.
  template <typename Visit>
  void walk(const google::protobuf::Descriptor& type, const Message* message, const std::string& path,
            int depth, const Visit& visit) const;

  std::unique_ptr<google::protobuf::DescriptorPool> pool_;
  std::unique_ptr<google::protobuf::DynamicMessageFactory> factory_;
  std::unique_ptr<Message> message_;
  std::map<std::string, int> repeats_;  // the longest, by the field's path
};

}  // namespace palpate::record::session
