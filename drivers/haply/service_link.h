// A connection to the maker's service, as a thread of arms::ExchangedArm uses it.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "drivers/arms/exchanged_arm.h"
#include "palpate/core/json.h"
#include "palpate/web/web_socket_client.h"

namespace palpate::drivers::haply {

// What the service has told of an arm, over all connections.
struct ToldByService {
  std::string id;  // asked for; empty: the first arm it has, from the first connection on that one's
  std::atomic<std::uint64_t> bad_states{0};
  mutable std::mutex guard;
  Json config;  // under guard
};

// Says hello until the configuration has come and is as asked for. `told` outlives the link.
Expected<std::unique_ptr<arms::ArmLink>> connect_to_service(const web::WebSocketAddress& service,
                                                            ToldByService& told);

}  // namespace palpate::drivers::haply
