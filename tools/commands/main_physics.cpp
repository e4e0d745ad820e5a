// The program of PALPATE_PARTS=physics: what a machine needs that runs the physics server and nothing else.
#include "tools/commands/program.h"

namespace palpate::tools::commands {
namespace {

void add_physics_commands(CLI::App& program) {
  add_apps(program);
  add_physics(program);
  add_keys(program);
  add_status(program);
}

}  // namespace
}  // namespace palpate::tools::commands

int main(int argc, char** argv) {
  return palpate::tools::commands::run_program(palpate::tools::commands::add_physics_commands, argc, argv);
}
