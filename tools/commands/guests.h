// The applications and drivers of this run of the program: those built in, those of the program's owner, and those of
// plug-ins. Filled before the commands are declared; from then on it is read.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpate/plugin/loader.h"
#include "tools/commands/drivers.h"

namespace palpate::tools::commands {

const scene::ApplicationRegistry& known_applications();
// drivers() of drivers.h
const plugin::Report& plugins();

// Fills them. Refused or wrong use: a plug-in of `files`; what is found elsewhere and not taken is told by a notice.
// Programs started from now on load `files`, too.
Expected<void> gather_guests(const std::function<void(plugin::Guests&)>& own,
                             const std::vector<std::string>& files);

}  // namespace palpate::tools::commands
