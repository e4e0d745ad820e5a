#include "tools/console/token.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>

#include "palpate/core/file.h"
#include "palpate/core/system_error.h"

namespace palpate::tools::console {

Expected<std::string> make_token(const std::filesystem::path& file) {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    return refused("console: no random numbers for a token ({}); check the system", reason_of(errno));
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  if (auto done = write_file(file, token + "\n", FileMode::own); !done) return tl::unexpected(done.error());
  return token;
}

bool same_token(std::string_view said, std::string_view token) {
  if (token.empty() || said.size() != token.size()) return false;
  unsigned differ = 0;
  for (std::size_t i = 0; i < token.size(); ++i)
    differ |= static_cast<unsigned char>(said[i]) ^ static_cast<unsigned char>(token[i]);
  return differ == 0;
}

bool holds_token(std::string_view target, std::string_view token) {
  const auto query = target.find('?');
  if (query == std::string_view::npos) return false;
  for (std::string_view rest = target.substr(query + 1); !rest.empty();) {
    const auto end = rest.find('&');
    const std::string_view one = rest.substr(0, end);
    if (one.starts_with("token=") && same_token(one.substr(6), token)) return true;
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  return false;
}

}  // namespace palpate::tools::console
