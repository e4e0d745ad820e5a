// The program of PALPATE_PARTS=physics: what a machine needs that runs the physics server and nothing else.
#include "tools/commands/command.h"

namespace palpate::tools::commands {

void add_commands(CLI::App& program) {
  add_apps(program);
  add_physics(program);
  add_keys(program);
  add_status(program);
  add_recording(program);
  add_replay(program);
  add_manual(program);
}

}  // namespace palpate::tools::commands
