// The schema of a protobuf message as it stands in a recording: its name and a FileDescriptorSet with all that it imports, so
// that a reader who has never heard of it can read it. Any thread.
#pragma once

#include <string>

#include "palpate/record/mcap.h"

namespace palpate::record::session {

// `message`: the full name of a type of proto/. Throws std::invalid_argument where there is none.
Schema schema_of(const std::string& message);

}  // namespace palpate::record::session
