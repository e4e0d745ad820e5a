// Server and client on one machine, for tests: waits are for what must come, however long a busy machine takes.
#pragma once

#include <gtest/gtest.h>

#include "drivers/openigtlink/protocol.h"
#include "tests/comes_true.h"

namespace palpate::drivers::openigtlink {

using tests::comes_true;

inline std::unique_ptr<network::PoseServer> server_at(std::uint16_t port = 0,
                                                      const ServerOptions& options = {}) {
  auto server = listen({"127.0.0.1", port}, options);
  EXPECT_TRUE(server.has_value()) << server.error().message;
  return server ? std::move(*server) : nullptr;
}

inline std::unique_ptr<network::PoseClient> client_of(const network::Address& address,
                                                      const ClientOptions& options = {}) {
  auto client = connect(address, options);
  EXPECT_TRUE(client.has_value()) << client.error().message;
  return client ? std::move(*client) : nullptr;
}

}  // namespace palpate::drivers::openigtlink
