// What comes over the network: bytes of both directions; what is accepted is encoded and read back the same.
#include "palpate/network/messages.h"

#include "fuzz/check.h"

namespace palpate::fuzz {

Refusals messages(std::string_view file) {
  Refusals refusals;
  if (const auto message = decode_client_message(file); answered(message, refusals)) {
    const auto bytes = encode(*message);
    const auto again = decode_client_message(bytes);
    hold(again && encode(*again) == bytes, "a client's message that was read can be sent on");
  }
  if (const auto message = decode_server_message(file); answered(message, refusals)) {
    const auto bytes = encode(*message);
    const auto again = decode_server_message(bytes);
    hold(again && encode(*again) == bytes, "a server's message that was read can be sent on");
  }
  return refusals;
}

}  // namespace palpate::fuzz
