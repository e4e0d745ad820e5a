// A secret that shows who may: 128 random bits as text, kept where only this user can read it. Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::tools::console {

// A new one, and the file written. Refused where there is no randomness; else as write_file().
Expected<std::string> make_token(const std::filesystem::path& file);

// In a time that tells nothing of where they differ. An empty token is nobody's.
bool same_token(std::string_view said, std::string_view token);

// Whether "token=..." stands in the query of a request's target: "/?token=...".
bool holds_token(std::string_view target, std::string_view token);

}  // namespace palpate::tools::console
