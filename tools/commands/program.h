// The whole program as a function: all of palpate's commands, for applications and drivers of one's own.
//
//   int main(int argc, char** argv) {
//     return palpate::tools::commands::run_program(argc, argv, [](palpate::plugin::Guests& guests) {
//       guests.applications.add(jelly::specification());
//     });
//   }
//
// CMake: palpate_add_program(NAME SOURCE ...), with the component tools_commands (docs/guides/library.md).
#pragma once

#include <functional>

#include "palpate/plugin/guests.h"

namespace palpate::tools::commands {

// main()'s result. `add_guests` adds to what this release has built in; plug-ins come after it, from --plugin and from
// where they are looked for (palpate/plugin/loader.h). What it throws is told in one line: exit 1. To be called once,
// by the main thread, before there are others: demo and play start the same executable again for their other parts.
int run_program(int argc, char** argv, const std::function<void(plugin::Guests&)>& add_guests = {});

}  // namespace palpate::tools::commands
