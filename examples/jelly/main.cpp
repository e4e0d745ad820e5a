// A program of one's own: all of palpate's commands, and the jelly.
#include "palpate/plugin/guests.h"
#include "specification.h"
#include "tools/commands/program.h"

int main(int argc, char** argv) {
  return palpate::tools::commands::run_program(
      argc, argv, [](palpate::plugin::Guests& guests) { guests.applications.add(jelly::specification()); });
}
