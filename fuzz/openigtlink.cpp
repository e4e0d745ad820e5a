// What comes from an OpenIGTLink server or client: the same messages in whatever pieces the bytes arrive, and
// what is read can be sent on.
#include <algorithm>
#include <cmath>

#include "drivers/openigtlink/message_stream.h"
#include "fuzz/check.h"

namespace palpate::fuzz {
namespace {

void hold_rigid(const drivers::openigtlink::RigidPose& pose) {
  hold(std::abs(pose.rotation.norm() - 1.0) < 1e-6 && pose.translation.allFinite(), "poses read are rigid");
}

struct HeardBytes {
  drivers::openigtlink::MessageStream stream;
  std::vector<std::string> messages;  // encoded again
  bool alive = true;

  void take(std::string_view bytes) {
    alive = stream.take(bytes, [this](drivers::openigtlink::Message&& message) {
      if (const auto* transform = std::get_if<drivers::openigtlink::Transform>(&message.content))
        hold_rigid(transform->pose);
      if (const auto* data = std::get_if<drivers::openigtlink::TrackingData>(&message.content))
        for (const auto& tool : data->tools) hold_rigid(tool.pose);
      const auto encoded = drivers::openigtlink::encode(message);
      hold(encoded.has_value(), "a message that was read can be sent on");
      const auto header = drivers::openigtlink::decode_header(*encoded);
      hold(header && drivers::openigtlink::decode_body(
                         *header, std::string_view(*encoded).substr(drivers::openigtlink::kHeaderBytes)),
           "a message that was sent on can be read");
      messages.push_back(*encoded);
    });
  }
};

}  // namespace

Refusals openigtlink(std::string_view file) {
  HeardBytes whole, pieces;
  whole.take(file);
  for (std::size_t at = 0, size = 1; at < file.size(); at += size, size = size % 97 + 1)
    pieces.take(file.substr(at, size));
  if (file.empty()) pieces.take(file);
  hold(whole.messages == pieces.messages && whole.alive == pieces.alive &&
           whole.stream.complaint() == pieces.stream.complaint(),
       "pieces of any size give the same messages");
  if (whole.stream.complaint().empty()) return {};
  hold_one_line({Error::Kind::refused, whole.stream.complaint()});
  return {whole.stream.complaint()};
}

}  // namespace palpate::fuzz
