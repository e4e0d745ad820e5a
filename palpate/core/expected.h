// A value, or the reason why there is none.
//
// Wrong use and broken set-up throw at construction; what the world does (device, network, file, data that
// cannot carry an answer) comes back as Expected. The two kinds of failure are the program's two exit codes.
#pragma once

#include <fmt/format.h>

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace palpate::inline core {

struct Error {
  enum class Kind {
    refused,    // ran, and the answer is no: the data or the machine cannot carry an answer (exit 1)
    wrong_use,  // what was asked for makes no sense: missing file, unknown key, bad option (exit 2)
  };
  Kind kind = Kind::refused;
  std::string message;  // one line: the thing, the value, the expectation, the remedy

  int exit_code() const { return kind == Kind::refused ? 1 : 2; }
};

template <typename T>
using Expected = tl::expected<T, Error>;

template <typename... Args>
tl::unexpected<Error> refused(fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(Error{Error::Kind::refused, fmt::format(format, std::forward<Args>(args)...)});
}

template <typename... Args>
tl::unexpected<Error> wrong_use(fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(
      Error{Error::Kind::wrong_use, fmt::format(format, std::forward<Args>(args)...)});
}

}  // namespace palpate::inline core
