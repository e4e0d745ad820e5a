// One device of a simulated laboratory behind the protocol of a real one:
//
//   palpate_doors tracker LABORATORY PORT
//   palpate_doors camera LABORATORY SERIAL EXPOSURE_MS RATE_HZ
//   palpate_doors arm LABORATORY SOCKET
//
// Says "ready" on standard output and serves until it is stopped or the laboratory ends. Never installed.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "palpate/core/stop_signal.h"
#include "tests/doors/arm_door.h"
#include "tests/doors/camera_door.h"
#include "tests/doors/tracker_door.h"

namespace {

void say_ready() {
  std::puts("ready");
  std::fflush(stdout);
}

palpate::Expected<void> serve(const std::vector<std::string>& words) {
  const auto& stop = palpate::stop_requested();
  const std::string kind = words.empty() ? "" : words[0];
  const std::size_t expected = kind == "camera" ? 5 : 3;
  if (words.size() != expected || (kind != "tracker" && kind != "camera" && kind != "arm"))
    return palpate::wrong_use(
        "tracker LABORATORY PORT, camera LABORATORY SERIAL EXPOSURE_MS RATE_HZ or arm LABORATORY SOCKET is "
        "expected");
  auto laboratory = palpate::drivers::laboratory::LabClient::open(words[1]);
  if (!laboratory) return tl::unexpected(laboratory.error());
  if (kind == "tracker")
    return palpate::doors::serve_tracker(*laboratory, static_cast<std::uint16_t>(std::atoi(words[2].c_str())),
                                         stop, say_ready);
  if (kind == "arm") return palpate::doors::serve_arm(*laboratory, words[2], stop, say_ready);
  return palpate::doors::serve_camera(
      *laboratory, {words[2], 1e-3 * std::atof(words[3].c_str()), std::atof(words[4].c_str())}, stop,
      say_ready);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto done = serve({argv + 1, argv + argc});
    if (done) return 0;
    std::fprintf(stderr, "palpate_doors: %s\n", done.error().message.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate_doors: %s\n", error.what());
  }
  return 1;
}
