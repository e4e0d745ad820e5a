// What comes over the network: bytes of both directions; what is accepted is encoded and read back the same.
#include <array>

#include "palpate/transport/messages.h"

#include "fuzz/check.h"

namespace palpate::fuzz {

Refusals messages(std::string_view file) {
  Refusals refusals;
  if (const auto message = transport::decode_client_message(file); answered(message, refusals)) {
    const auto bytes = transport::encode(*message);
    const auto again = transport::decode_client_message(bytes);
    hold(again && transport::encode(*again) == bytes, "a client's message that was read can be sent on");
  }
  if (const auto message = transport::decode_server_message(file); answered(message, refusals)) {
    const auto bytes = transport::encode(*message);
    const auto again = transport::decode_server_message(bytes);
    hold(again && transport::encode(*again) == bytes, "a server's message that was read can be sent on");
  }
  // The same with a shape in two frames: the first two bytes say how long the first frame is.
  if (file.size() < 2) return refusals;
  const std::size_t length = static_cast<unsigned char>(file[0]) + 256 * static_cast<unsigned char>(file[1]);
  const std::string_view frames = file.substr(2), first = frames.substr(0, length);
  const std::string_view shape_bytes = frames.substr(first.size());
  const std::size_t half = shape_bytes.size() / 2;
  const std::array pieces{shape_bytes.substr(0, half), shape_bytes.substr(half)};
  if (const auto message = transport::decode_server_message(first, pieces); answered(message, refusals)) {
    const auto shape = transport::shape_of(*message);
    hold(shape != nullptr, "frames that were accepted are a shape");
    const auto again =
        transport::decode_server_message(transport::encode(*message), transport::shape_pieces(*shape));
    hold(again && transport::shape_of(*again)->values == shape->values,
         "a shape that was read can be sent on");
  }
  return refusals;
}

}  // namespace palpate::fuzz
