#include "palpate/record/session/internal/flat_message.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.pb.h>

#include <algorithm>

#include "palpate/core/text.h"

namespace palpate::record::session {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// One value of a field; `index` < 0: it does not repeat.
std::string cell_of(const Message& message, const FieldDescriptor& field, int index) {
  const auto& r = *message.GetReflection();
  const bool one = index < 0;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return fmt::format("{}",
                         one ? r.GetDouble(message, &field) : r.GetRepeatedDouble(message, &field, index));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return fmt::format("{}",
                         one ? r.GetFloat(message, &field) : r.GetRepeatedFloat(message, &field, index));
    case FieldDescriptor::CPPTYPE_INT32:
      return fmt::format("{}",
                         one ? r.GetInt32(message, &field) : r.GetRepeatedInt32(message, &field, index));
    case FieldDescriptor::CPPTYPE_INT64:
      return fmt::format("{}",
                         one ? r.GetInt64(message, &field) : r.GetRepeatedInt64(message, &field, index));
    case FieldDescriptor::CPPTYPE_UINT32:
      return fmt::format("{}",
                         one ? r.GetUInt32(message, &field) : r.GetRepeatedUInt32(message, &field, index));
    case FieldDescriptor::CPPTYPE_UINT64:
      return fmt::format("{}",
                         one ? r.GetUInt64(message, &field) : r.GetRepeatedUInt64(message, &field, index));
    case FieldDescriptor::CPPTYPE_BOOL:
      return (one ? r.GetBool(message, &field) : r.GetRepeatedBool(message, &field, index)) ? "1" : "0";
    case FieldDescriptor::CPPTYPE_ENUM:
      return (one ? r.GetEnum(message, &field) : r.GetRepeatedEnum(message, &field, index))->name();
    case FieldDescriptor::CPPTYPE_STRING: {
      const std::string text =
          one ? r.GetString(message, &field) : r.GetRepeatedString(message, &field, index);
      return field.type() == FieldDescriptor::TYPE_BYTES ? fmt::format("{}", text.size())
                                                         : excerpt(text, 500);
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      break;
  }
  return {};
}

// What is wrong with a schema of others is told in one line, by us.
class Silence : public google::protobuf::DescriptorPool::ErrorCollector {
 public:
  void AddError(const std::string&, const std::string&, const Message*, ErrorLocation,
                const std::string&) override {}
};

}  // namespace

Expected<FlatMessage> FlatMessage::of(const Schema& schema) {
  google::protobuf::FileDescriptorSet files;
  if (schema.encoding != "protobuf" || !files.ParseFromString(schema.data))
    return refused("the schema {} is not one of protobuf", excerpt(schema.name));
  FlatMessage flat;
  flat.pool_ = std::make_unique<google::protobuf::DescriptorPool>();
  Silence silence;
  for (const auto& file : files.file())
    if (flat.pool_->FindFileByName(file.name()) == nullptr &&
        flat.pool_->BuildFileCollectingErrors(file, &silence) == nullptr)
      return refused("the schema {} is damaged", excerpt(schema.name));
  const auto* type = flat.pool_->FindMessageTypeByName(schema.name);
  if (type == nullptr) return refused("the schema {} does not hold its own type", excerpt(schema.name));
  flat.factory_ = std::make_unique<google::protobuf::DynamicMessageFactory>(flat.pool_.get());
  flat.message_.reset(flat.factory_->GetPrototype(type)->New());
  return flat;
}

bool FlatMessage::measure(std::string_view bytes) {
  if (!message_->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return false;
  measure(*message_, "", 0);
  return true;
}

void FlatMessage::measure(const Message& message, const std::string& path, int depth) {
  const auto& type = *message.GetDescriptor();
  const auto& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const Field& field = *type.field(i);
    const std::string name = path + field.name();
    const bool nested = field.cpp_type() == Field::CPPTYPE_MESSAGE;
    if (field.is_repeated()) {
      const int count = std::min(reflection.FieldSize(message, &field), kMostRepeats);
      int& longest = repeats_[name];
      longest = std::max(longest, count);
      if (nested && depth < kDeepest)
        for (int k = 0; k < count; ++k)
          measure(reflection.GetRepeatedMessage(message, &field, k), fmt::format("{}.{}.", name, k),
                  depth + 1);
    } else if (nested && depth < kDeepest && reflection.HasField(message, &field)) {
      measure(reflection.GetMessage(message, &field), name + ".", depth + 1);
    }
  }
}

template <typename Visit>
void FlatMessage::walk(const google::protobuf::Descriptor& type, const Message* message,
                       const std::string& path, int depth, const Visit& visit) const {
  for (int i = 0; i < type.field_count(); ++i) {
    const Field& field = *type.field(i);
    const std::string name = path + field.name();
    const bool nested = field.cpp_type() == Field::CPPTYPE_MESSAGE;
    if (nested && depth >= kDeepest) continue;
    if (!field.is_repeated()) {
      if (!nested) {
        visit(name, message, field, -1);
        continue;
      }
      const bool there = message != nullptr && message->GetReflection()->HasField(*message, &field);
      walk(*field.message_type(), there ? &message->GetReflection()->GetMessage(*message, &field) : nullptr,
           name + ".", depth + 1, visit);
      continue;
    }
    const auto longest = repeats_.find(name);
    const int columns = longest == repeats_.end() ? 0 : longest->second;
    const int count = message == nullptr ? 0 : message->GetReflection()->FieldSize(*message, &field);
    for (int k = 0; k < columns; ++k) {
      const std::string element = fmt::format("{}.{}", name, k);
      const bool there = k < count;
      if (!nested)
        visit(element, there ? message : nullptr, field, k);
      else
        walk(*field.message_type(),
             there ? &message->GetReflection()->GetRepeatedMessage(*message, &field, k) : nullptr,
             element + ".", depth + 1, visit);
    }
  }
}

std::vector<std::string> FlatMessage::columns() const {
  std::vector<std::string> names;
  walk(*message_->GetDescriptor(), nullptr, "", 0,
       [&](const std::string& name, const Message*, const Field&, int) { names.push_back(name); });
  return names;
}

std::vector<std::string> FlatMessage::cells(std::string_view bytes) const {
  std::vector<std::string> cells;
  if (!message_->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return cells;
  walk(*message_->GetDescriptor(), message_.get(), "", 0,
       [&](const std::string&, const Message* message, const Field& field, int index) {
         cells.push_back(message == nullptr ? "" : cell_of(*message, field, index));
       });
  return cells;
}

}  // namespace palpate::record::session
