// What comes from an NDI tracker or from a client of one: the same replies in whatever pieces the bytes arrive, and what is read
// can be written again; a simulated tracker answers whatever it is asked with a reply that is whole.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "drivers/ndi/internal/simulated_device.h"
#include "drivers/ndi/reply_stream.h"
#include "fuzz/check.h"

namespace palpate::fuzz {
namespace {

namespace ndi = drivers::ndi;

void hold_rigid(const ndi::Reading& reading) {
  hold(std::abs(reading.pose.rotation.norm() - 1.0) < 1e-6 && reading.pose.translation.allFinite(),
       "poses read are rigid");
}

// As a body of each kind that a client may have asked for. The refusal of the kind that it looks like.
std::string read_poses(const std::string& body) {
  std::string of_bx, of_bx2;
  if (const auto readings = ndi::decode_bx(body)) {
    for (const auto& reading : *readings) hold_rigid(reading);
    hold(ndi::encode_tx(*readings).size() >= 6, "readings can be told as text");
    const auto again = ndi::decode_bx(ndi::encode_bx(*readings));
    hold(again && again->size() == readings->size(), "readings come back");
  } else {
    of_bx = readings.error().message;
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
    of_bx2 = frames.error().message;
  }
  for (const auto& refusal : {of_bx, of_bx2})
    if (!refusal.empty()) hold_one_line({Error::Kind::refused, refusal});
  constexpr std::string_view kVersion("\1\0", 2);
  return of_bx.empty() || of_bx2.empty() ? "" : body.starts_with(kVersion) ? of_bx2 : of_bx;
}

std::string read_text(const std::string& words) {
  std::string of_handles, of_tool;
  if (const auto code = ndi::error_of(words)) hold_one_line({Error::Kind::refused, ndi::words_of(*code)});
  if (const auto handles = ndi::decode_handles(words))
    hold(ndi::encode_handles(*handles) == words, "handles come back");
  else
    of_handles = handles.error().message;
  if (const auto info = ndi::decode_tool_info(words); !info)
    of_tool = info.error().message;
  else if (*info)
    hold(ndi::decode_tool_info(ndi::encode_tool_info(**info)).has_value(), "what a tool is comes back");
  // What a client says has the same form.
  if (const auto command = ndi::decode_command(words))
    hold(!command->name.empty() && command->parameters.size() <= words.size(), "a command is of its line");
  for (const auto& refusal : {of_handles, of_tool})
    if (!refusal.empty()) hold_one_line({Error::Kind::refused, refusal});
  if (words == "OKAY" || ndi::error_of(words) || of_handles.empty() || of_tool.empty()) return "";
  return words.size() < 20 ? of_handles : of_tool;
}

// The lines of the file as commands, to a tracker of two tools of which one is in sight. Checksums would keep a fuzzer out.
void ask_device(std::string_view lines) {
  constexpr std::int64_t kStep = 1'000'000;
  ndi::SimulatedDevice device(true);
  for (const char* tool : {"Stylus", "Head"}) device.plug_in(tool);
  std::int64_t now_ns = 0;
  for (int i = 0; i < 50 && !lines.empty(); ++i, now_ns += kStep) {
    const auto line = lines.substr(0, lines.find('\r'));
    lines.remove_prefix(std::min(line.size() + 1, lines.size()));
    device.pose({"Stylus", std::nullopt, {}, nullptr, now_ns});
    const auto colon = line.find_first_of(": ");
    std::string answer;
    if (colon == std::string_view::npos)
      answer = device.answer({std::string(line), ""}, now_ns);
    else
      answer =
          device.answer({std::string(line.substr(0, colon)), std::string(line.substr(colon + 1))}, now_ns);
    int replies = 0;
    ndi::ReplyStream stream;
    stream.take(answer, [&](ndi::Reply&& reply) {
      ++replies;
      hold(!reply.damaged, "the device's replies have their checksums");
    });
    hold(replies == 1 && stream.complaint().empty(), "the device replies once to each command");
  }
}

struct HeardNdi {
  ndi::ReplyStream stream;
  std::vector<std::string> replies, refusals;
  bool alive = true;

  void take(std::string_view bytes) {
    alive = stream.take(bytes, [this](ndi::Reply&& reply) {
      replies.push_back(reply.damaged ? "damaged" : reply.content);
      if (reply.damaged) return;
      auto refusal = reply.binary ? read_poses(reply.content) : read_text(reply.content);
      if (!refusal.empty()) refusals.push_back(std::move(refusal));
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
  if (file.size() <= ndi::kMostBody) read_poses(std::string(file));
  ask_device(file);
  Refusals refusals(whole.refusals.begin(), whole.refusals.end());
  if (!whole.stream.complaint().empty()) refusals.push_back(whole.stream.complaint());
  for (const auto& refusal : refusals) hold_one_line({Error::Kind::refused, refusal});
  return refusals;
}

}  // namespace palpate::fuzz
