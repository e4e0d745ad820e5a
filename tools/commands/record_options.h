// --record and --pictures of the commands that can record what they do.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/record/session/recorded_drivers.h"

namespace palpate::tools::commands {

struct RecordOptions {
  std::string file;               // empty: nothing is recorded
  std::string pictures = "none";  // none, jpeg, lossless
};

void add_record_options(CLI::App& command, RecordOptions& options);
void add_picture_option(CLI::App& command, RecordOptions& options);  // --pictures alone

// How pictures are recorded. Wrong use where they are asked for and nothing is recorded.
Expected<record::session::PictureRecording> picture_recording(const RecordOptions& options);

}  // namespace palpate::tools::commands
