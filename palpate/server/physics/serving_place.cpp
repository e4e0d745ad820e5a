#include "palpate/server/physics/serving_place.h"

#include <utility>

namespace palpate::server::physics {

Expected<ServingPlace> serving_place(const std::string& address, bool insecure,
                                     const std::filesystem::path& keys) {
  auto endpoint = address.empty()
                      ? transport::default_endpoint()
                      : transport::parse_endpoint(address, transport::EndpointUse::listen, insecure);
  if (!endpoint) return tl::unexpected(endpoint.error());
  ServingPlace place{std::move(*endpoint), std::nullopt};
  if (!place.endpoint.encrypted) return place;
  const auto folder = keys.empty() ? transport::keys_folder() : Expected<std::filesystem::path>(keys);
  if (!folder) return tl::unexpected(folder.error());
  auto identity = transport::server_identity(*folder);
  if (!identity) return tl::unexpected(identity.error());
  place.identity = std::move(*identity);
  return place;
}

void tell_who_is_admitted(const ServingPlace& place, const Log& log) {
  if (!place.endpoint.local() && !place.identity)
    log.warning("warning: {} is neither encrypted nor guarded: whoever reaches it sees and commands",
                place.endpoint.address);
  if (!place.identity) return;
  log.info("key of this server {}", place.identity->own.public_key);
  const auto admitted =
      transport::read_authorized_keys(place.identity->folder).value_or(transport::AuthorizedKeys{});
  for (const auto& complaint : admitted.complaints) log.warning("warning: {}", complaint);
  if (admitted.keys.empty()) log.warning("warning: nobody is admitted yet; `palpate keys authorize` admits");
}

}  // namespace palpate::server::physics
