#include "palpate/core/machine.h"

#include <sched.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string_view>

namespace palpate::inline core {
namespace {

// What follows the key and its separator in the first line that begins with the key: "model name : X", "NAME="X"".
std::string value_in(const char* file, std::string_view key, char separator) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    const auto at = line.find(separator);
    if (!line.starts_with(key) || at == std::string::npos) continue;
    const auto begin = line.find_first_not_of(" \t\"", at + 1), end = line.find_last_not_of(" \t\"");
    return begin == std::string::npos ? "" : line.substr(begin, end - begin + 1);
  }
  return "";
}

}  // namespace

Machine this_machine() {
  Machine machine{.processor = value_in("/proc/cpuinfo", "model name", ':'),
                  .system = value_in("/etc/os-release", "PRETTY_NAME", '=')};
  cpu_set_t cores;
  CPU_ZERO(&cores);
  if (::sched_getaffinity(0, sizeof cores, &cores) == 0)
    machine.cores = static_cast<unsigned>(std::max(1, CPU_COUNT(&cores)));
  utsname names{};
  if (::uname(&names) == 0) machine.kernel = std::string(names.sysname) + ' ' + names.release;
  return machine;
}

std::optional<double> load_of_machine() {
  double load = 0.0;
  if (::getloadavg(&load, 1) != 1) return std::nullopt;
  return load;
}

}  // namespace palpate::inline core
