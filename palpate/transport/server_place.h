// A physics server as a person names it to a client, and what is needed to get there. Any thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "palpate/transport/keys.h"
#include "palpate/transport/local_endpoint.h"

namespace palpate::transport {

struct ServerName {
  std::string address;  // empty = this user's own server
  bool insecure = false;
  std::filesystem::path keys;  // folder; empty = this user's
  std::string server_key;      // empty = the one known for the address
};

struct ServerPlace {
  Endpoint endpoint;
  std::optional<ClientIdentity> identity;  // where the endpoint is encrypted
};

// Wrong use: what is no address. Refused: an encrypted address whose keys are not there.
Expected<ServerPlace> server_place(const ServerName& name);

}  // namespace palpate::transport
