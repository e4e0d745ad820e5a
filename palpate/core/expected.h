// A value, or the reason why there is none.
//
// Wrong use and broken set-up throw at construction; what the world does (device, network, file, data that
// cannot carry an answer) comes back as Expected, which the compiler lets nobody pass over. The two kinds of
// failure are the program's two exit codes. A caller that goes on in spite of a failure decides so by its code,
// never by its message.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace palpate::inline core {

// Causes that a caller can do something about. Most failures have none: they end what was being done.
enum class ErrorCode : std::uint8_t {
  unspecified,
  no_more,       // there are no further ones: what was asked for lies beyond the last
  out_of_reach,  // this one cannot be reached; another may be
  timed_out,
  not_found,     // no such file, device or peer
  in_use,        // somebody else has it
  exhausted,     // no descriptor, memory or place is left now; later there may be
  disconnected,  // a device or a peer has gone
  stopped,       // a person said so
};

struct Error {
  enum class Kind {
    refused,    // ran, and the answer is no: the data or the machine cannot carry an answer (exit 1)
    wrong_use,  // what was asked for makes no sense: missing file, unknown key, bad option (exit 2)
  };
  Kind kind = Kind::refused;
  std::string message;  // one line: the thing, the value, the expectation, the remedy
  ErrorCode code = ErrorCode::unspecified;

  int exit_code() const { return kind == Kind::refused ? 1 : 2; }
};

// tl::expected of Debian 12 is older than its [[nodiscard]].
template <typename T>
class [[nodiscard]] Expected : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
  Expected() = default;
};

template <typename... Args>
tl::unexpected<Error> refused(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(
      Error{Error::Kind::refused, fmt::format(format, std::forward<Args>(args)...), code});
}
template <typename... Args>
tl::unexpected<Error> refused(fmt::format_string<Args...> format, Args&&... args) {
  return refused(ErrorCode::unspecified, format, std::forward<Args>(args)...);
}

template <typename... Args>
tl::unexpected<Error> wrong_use(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(
      Error{Error::Kind::wrong_use, fmt::format(format, std::forward<Args>(args)...), code});
}
template <typename... Args>
tl::unexpected<Error> wrong_use(fmt::format_string<Args...> format, Args&&... args) {
  return wrong_use(ErrorCode::unspecified, format, std::forward<Args>(args)...);
}

}  // namespace palpate::inline core
