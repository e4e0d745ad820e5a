// Where a physics server listens and who may come in: an endpoint as a person names it, and the keys that an encrypted one needs.
//
// Ordinary threads. Errors: wrong use for a text that is no endpoint, or one that would be open to strangers; refused where the keys
// cannot be had.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/log.h"
#include "palpate/transport/keys.h"
#include "palpate/transport/local_endpoint.h"

namespace palpate::server::physics {

struct ServingPlace {
  transport::Endpoint endpoint;
  std::optional<transport::ServerIdentity> identity;
};

// `address`: empty = this user's default socket; `keys`: folder, empty = this user's.
Expected<ServingPlace> serving_place(const std::string& address, bool insecure,
                                     const std::filesystem::path& keys);

// What a person should know of who may come in.
void tell_who_is_admitted(const ServingPlace& place, const Log& log);

}  // namespace palpate::server::physics
