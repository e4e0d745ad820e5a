// The program of PALPATE_PARTS=physics: what a machine needs that runs the physics server and nothing else.
#include "apps/palpate/program.h"

namespace palpate::app {
namespace {

void add_physics_commands(CLI::App& program) {
  add_apps(program);
  add_physics(program);
  add_keys(program);
  add_status(program);
}

}  // namespace
}  // namespace palpate::app

int main(int argc, char** argv) {
  return palpate::app::run_program(palpate::app::add_physics_commands, argc, argv);
}
