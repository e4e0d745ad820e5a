// A pretended camera as a process, for the tests of the program: SERIAL, and "board" or "laboratory". Says
// "ready" on standard output and sends pictures until it is killed.
#include "tests/fake_network_camera.h"

#include <unistd.h>

#include <cstdio>
#include <exception>

#include "tests/rendered_views.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const bool board = std::string(argv[2]) == "board";
    const palpate::FakeNetworkCamera camera(argv[1], palpate::rendered_views(board ? 16 : 4, board),
                                            board ? 6 : 1);
    std::puts("ready");
    std::fflush(stdout);
    while (true) pause();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
