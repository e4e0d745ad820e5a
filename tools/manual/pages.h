// Manual pages of a program, one for each of its commands, for man(1): troff with the macros of man(7).
#pragma once

#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "tools/manual/description.h"

namespace palpate::tools::manual {

// "palpate-calibrate-pivot"
std::string page_name(const Command& command);

// `version`: what stands at the page's foot. The same tree gives the same bytes.
std::string manual_page(const Command& command, const std::string& version);

// One file a command, page_name() and ".1", into a folder that is there.
Expected<void> write_manual_pages(const Command& program, const std::string& version,
                                  const std::string& folder);

}  // namespace palpate::tools::manual
