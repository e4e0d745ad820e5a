// What comes from an NDI tracker or from a client of one: the same replies in whatever pieces the bytes arrive, and what is read
// can be written again.
#include <cmath>
#include <string>
#include <vector>

#include "drivers/ndi/reply_stream.h"
#include "fuzz/check.h"

namespace palpate::fuzz {
namespace {

namespace ndi = drivers::ndi;

void hold_rigid(const ndi::Reading& reading) {
  hold(std::abs(reading.pose.rotation.norm() - 1.0) < 1e-6 && reading.pose.translation.allFinite(),
       "poses read are rigid");
}

// As a body of each kind that a client may have asked for; of text, too.
void read_poses(const std::string& body, std::vector<std::string>& refusals) {
  if (const auto readings = ndi::decode_bx(body)) {
    for (const auto& reading : *readings) hold_rigid(reading);
    hold(ndi::encode_tx(*readings).size() >= 6, "readings can be told as text");
    const auto again = ndi::decode_bx(ndi::encode_bx(*readings));
    hold(again && again->size() == readings->size(), "readings come back");
  } else {
    refusals.push_back(readings.error().message);
  }
  if (const auto frames = ndi::decode_bx2(body)) {
    for (const auto& frame : *frames)
      for (const auto& reading : frame.tools) hold_rigid(reading);
    const auto again = ndi::decode_bx2(ndi::encode_bx2(*frames));
    hold(again && again->size() == frames->size(), "frames come back");
    for (std::size_t i = 0; i < frames->size(); ++i)
      hold((*again)[i].stamp == (*frames)[i].stamp && (*again)[i].tools.size() == (*frames)[i].tools.size(),
           "a frame that was written again is the same");
  } else {
    refusals.push_back(frames.error().message);
  }
}

void read_text(const std::string& words, std::vector<std::string>& refusals) {
  if (const auto code = ndi::error_of(words))
    refusals.push_back(ndi::words_of(*code) + "; use another command");
  if (const auto handles = ndi::decode_handles(words))
    hold(ndi::encode_handles(*handles) == words, "handles come back");
  else
    refusals.push_back(handles.error().message);
  if (const auto info = ndi::decode_tool_info(words); !info)
    refusals.push_back(info.error().message);
  else if (*info)
    hold(ndi::decode_tool_info(ndi::encode_tool_info(**info)).has_value(), "what a tool is comes back");
  // What a client says has the same form.
  if (const auto command = ndi::decode_command(words))
    hold(!command->name.empty() && command->parameters.size() <= words.size(), "a command is of its line");
}

struct HeardNdi {
  ndi::ReplyStream stream;
  std::vector<std::string> replies, refusals;
  bool alive = true;

  void take(std::string_view bytes) {
    alive = stream.take(bytes, [this](ndi::Reply&& reply) {
      replies.push_back(reply.damaged ? "damaged" : reply.content);
      if (reply.damaged) return;
      if (reply.binary)
        read_poses(reply.content, refusals);
      else
        read_text(reply.content, refusals);
    });
  }
};

}  // namespace

Refusals ndi_replies(std::string_view file) {
  HeardNdi whole, pieces;
  whole.take(file);
  for (std::size_t at = 0, size = 1; at < file.size(); at += size, size = size % 97 + 1)
    pieces.take(file.substr(at, size));
  if (file.empty()) pieces.take(file);
  hold(whole.replies == pieces.replies && whole.alive == pieces.alive && whole.refusals == pieces.refusals &&
           whole.stream.complaint() == pieces.stream.complaint(),
       "pieces of any size give the same replies");
  // Checksums keep a fuzzer out: the bytes as a body, too.
  if (file.size() <= ndi::kMostBody) read_poses(std::string(file), whole.refusals);
  Refusals refusals(whole.refusals.begin(), whole.refusals.end());
  if (!whole.stream.complaint().empty()) refusals.push_back(whole.stream.complaint());
  for (const auto& refusal : refusals) hold_one_line({Error::Kind::refused, refusal});
  return refusals;
}

}  // namespace palpate::fuzz
