#include "palpate/transport/server_place.h"

namespace palpate::transport {

Expected<ServerPlace> server_place(const ServerName& name) {
  auto endpoint = name.address.empty() ? default_endpoint()
                                       : parse_endpoint(name.address, EndpointUse::connect, name.insecure);
  if (!endpoint) return tl::unexpected(endpoint.error());
  if (!endpoint->encrypted) return ServerPlace{std::move(*endpoint), std::nullopt};
  const auto folder = name.keys.empty() ? keys_folder() : Expected<std::filesystem::path>(name.keys);
  if (!folder) return tl::unexpected(folder.error());
  auto identity = client_identity(*folder, endpoint->address, name.server_key);
  if (!identity) return tl::unexpected(identity.error());
  return ServerPlace{std::move(*endpoint), std::move(*identity)};
}

}  // namespace palpate::transport
