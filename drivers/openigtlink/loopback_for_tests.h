// Publisher and driver on one machine, for tests: waits are for what must come, however long a busy machine takes.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "drivers/openigtlink/pose_publisher.h"
#include "drivers/openigtlink/tracker_client.h"

namespace palpate::drivers::openigtlink {

inline bool comes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 12'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

inline std::unique_ptr<PosePublisher> publisher_at(std::uint16_t port = 0,
                                                   const PublisherOptions& options = {}) {
  auto publisher = PosePublisher::listen({"127.0.0.1", port}, options);
  EXPECT_TRUE(publisher.has_value()) << publisher.error().message;
  return publisher ? std::move(*publisher) : nullptr;
}

inline std::unique_ptr<TrackerClient> client_of(const Address& address,
                                                const TrackerClientOptions& options = {}) {
  auto client = TrackerClient::connect(address, options);
  EXPECT_TRUE(client.has_value()) << client.error().message;
  return client ? std::move(*client) : nullptr;
}

}  // namespace palpate::drivers::openigtlink
