// A program of one's own: all of palpate's commands, and the camera.
#include "palpate/plugin/guests.h"
#include "ppm_camera.h"
#include "tools/commands/program.h"

int main(int argc, char** argv) {
  return palpate::tools::commands::run_program(
      argc, argv, [](palpate::plugin::Guests& guests) { guests.drivers.add(ppm::driver()); });
}
