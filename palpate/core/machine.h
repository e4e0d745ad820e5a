// The machine that a program runs on, as far as results depend on it.
#pragma once

#include <optional>
#include <string>

namespace palpate::inline core {

struct Machine {
  std::string processor;  // as it names itself; empty: it does not say
  unsigned cores = 0;     // that this process may use
  std::string kernel;     // "Linux 6.1.0-18-amd64"
  std::string system;     // "Debian GNU/Linux 12 (bookworm)"; empty: not known
};
Machine this_machine();

// How many threads have wanted to run, on average over the last minute; none: not known.
std::optional<double> load_of_machine();

}  // namespace palpate::inline core
