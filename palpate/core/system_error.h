// Why the system refused, for a message: its own words for an errno, with the remedy where a limit of this process is
// the cause.
#pragma once

#include <cerrno>
#include <cstring>
#include <string>

namespace palpate::inline core {

inline std::string reason_of(int error) {
  const std::string words = std::strerror(error);
  return error == EMFILE || error == ENFILE ? words + "; raise the limit (ulimit -n)" : words;
}

}  // namespace palpate::inline core
