// Files of other programs, recognised by what is in them, never by their names.
//
// Errors: wrong use: a file that is missing, of no known form, or of one that is known and not read; a file that holds several
// bodies, of which none was named. The message names the form, and file and line of what is wrong. Pure but for the file that
// is read; any thread. Forms, their frames and sources: docs/files-of-others.md.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/formats/content.h"

namespace palpate::formats {

struct ReadOptions {
  std::string form;  // one of form_names(); empty: found by itself
  std::string tool;  // which body, where a file holds several side by side; a sequence's transform AToB
  double metres_per_unit = 0;  // of a file that does not say; 0: unknown
};

// "tum" and so on, of the forms that can be named.
std::vector<std::string> form_names();

Expected<Content> read(const std::filesystem::path& path, const ReadOptions& options = {});
// The same of what has been read already; `source` names it in messages.
Expected<Content> parse(std::string_view content, const std::string& source, const ReadOptions& options = {});

}  // namespace palpate::formats
