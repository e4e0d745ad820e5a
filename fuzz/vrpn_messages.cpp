// What comes from a VRPN server or client: the same messages in whatever pieces the bytes arrive, and what is read can be
// sent on.
#include <cmath>
#include <string>
#include <vector>

#include "drivers/vrpn/message_stream.h"
#include "fuzz/check.h"

namespace palpate::fuzz {
namespace {

namespace vrpn = drivers::vrpn;

struct HeardVrpn {
  vrpn::MessageStream stream;
  std::vector<std::string> messages, refusals;
  bool alive = true;

  void take(std::string_view bytes) {
    alive = stream.take(bytes, [this](vrpn::Message&& message) {
      const auto encoded = vrpn::encode(message);
      hold(encoded.has_value(), "a message that was read can be sent on");
      const auto header = vrpn::decode_header(*encoded);
      hold(header && header->stamp == message.stamp && header->sender == message.sender &&
               header->type == message.type &&
               encoded->substr(vrpn::kHeaderBytes, header->payload_bytes) == message.payload,
           "a message that was sent on is the same");
      messages.push_back(*encoded);
      if (message.type == vrpn::kSenderDescription || message.type == vrpn::kTypeDescription) {
        const auto name = vrpn::decode_name(message.payload);
        if (!name)
          refusals.push_back(name.error().message);
        else
          hold(vrpn::decode_name(vrpn::encode_name(*name)) == *name, "a name comes back");
      } else if (const auto pose = vrpn::decode_pose(message.payload)) {
        hold(std::abs(pose->pose.rotation.norm() - 1.0) < 1e-6 && pose->pose.translation.allFinite(),
             "poses read are rigid");
      } else {
        refusals.push_back(pose.error().message);
      }
    });
  }
};

}  // namespace

Refusals vrpn_messages(std::string_view file) {
  HeardVrpn whole, pieces;
  whole.take(file);
  for (std::size_t at = 0, size = 1; at < file.size(); at += size, size = size % 97 + 1)
    pieces.take(file.substr(at, size));
  if (file.empty()) pieces.take(file);
  hold(whole.messages == pieces.messages && whole.alive == pieces.alive &&
           whole.refusals == pieces.refusals && whole.stream.complaint() == pieces.stream.complaint(),
       "pieces of any size give the same messages");
  Refusals refusals(whole.refusals.begin(), whole.refusals.end());
  if (!whole.stream.complaint().empty()) refusals.push_back(whole.stream.complaint());
  for (const auto& refusal : refusals) hold_one_line({Error::Kind::refused, refusal});
  return refusals;
}

}  // namespace palpate::fuzz
