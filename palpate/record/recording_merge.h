// One recording of several: those of the servers of a session, made side by side on one timeline (SessionRecording), or by two
// machines whose clocks agree.
//
// Messages come in the order of their log times; where two recordings have a topic in common, its sequence numbers go on, and
// gaps remain gaps. Attachments of the same name and content stand there once. Ordinary threads. Errors: wrong use for a file that
// cannot be read; refused where one is not whole (repair it first), or the copy cannot be written.
#pragma once

#include <filesystem>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/record/mcap.h"

namespace palpate::record {

// There whole or not at all; "-" is standard output.
Expected<Statistics> merge(const std::vector<std::filesystem::path>& recordings,
                           const std::filesystem::path& out);

}  // namespace palpate::record
