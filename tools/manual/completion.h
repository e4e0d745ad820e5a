// Completion of a program's command line by a shell, as the script that the shell reads.
#pragma once

#include <string>

#include "tools/manual/description.h"

namespace palpate::tools::manual {

// For bash 4 or newer: commands, options, choices, names of files and folders; after "--option=" as well.
std::string bash_completion(const Command& program);

}  // namespace palpate::tools::manual
