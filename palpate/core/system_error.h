// Why the system refused: an errno in words for a message, with the remedy where a limit of this process is the cause, and
// as a code for whoever decides by it.
#pragma once

#include <cerrno>
#include <cstring>
#include <string>

#include "palpate/core/expected.h"

namespace palpate::inline core {

inline std::string reason_of(int error) {
  const std::string words = std::strerror(error);
  return error == EMFILE || error == ENFILE ? words + "; raise the limit (ulimit -n)" : words;
}

inline ErrorCode code_of(int error) {
  switch (error) {
    case EMFILE:
    case ENFILE:
    case ENOMEM:
      return ErrorCode::exhausted;
    case ENOENT:
      return ErrorCode::not_found;
    default:
      return ErrorCode::unspecified;
  }
}

}  // namespace palpate::inline core
