// The list of admitted keys.
#include "palpate/transport/keys.h"

#include "fuzz/check.h"

namespace palpate::fuzz {

Refusals keys(std::string_view file) {
  transport::AuthorizedKeys read = transport::parse_authorized_keys(file, "authorized_keys");
  for (const auto& key : read.keys) {
    hold(transport::is_key(key.key), "an admitted key is a key");
    hold(read.role_of(key.key) == key.role, "a key has one role");
  }
  for (const auto& complaint : read.complaints)
    hold(complaint.find('\n') == std::string::npos, "a complaint is one line");
  return std::move(read.complaints);
}

}  // namespace palpate::fuzz
