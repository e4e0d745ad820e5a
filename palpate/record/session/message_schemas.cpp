#include "palpate/record/session/message_schemas.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <set>
#include <stdexcept>

namespace palpate::record::session {
namespace {

using google::protobuf::FileDescriptor;

// What a file imports stands before it.
void add_file(const FileDescriptor& file, std::set<const FileDescriptor*>& seen,
              google::protobuf::FileDescriptorSet& files) {
  if (!seen.insert(&file).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_file(*file.dependency(i), seen, files);
  file.CopyTo(files.add_file());
}

}  // namespace

Schema schema_of(const std::string& message) {
  const auto* type = google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(message);
  if (type == nullptr) throw std::invalid_argument("recording: no message is called " + message);
  google::protobuf::FileDescriptorSet files;
  std::set<const FileDescriptor*> seen;
  add_file(*type->file(), seen, files);
  return {message, "protobuf", files.SerializeAsString()};
}

}  // namespace palpate::record::session
