#include "drivers/ndi/reply_stream.h"

#include <algorithm>

#include "drivers/ndi/internal/limits.h"
#include "palpate/core/text.h"

namespace palpate::drivers::ndi {
namespace {

constexpr char kStart = '\xa5', kShort = '\xc4', kLong = '\xc8';  // the start's bytes, the second one first
constexpr std::size_t kChecksumBytes = 2, kStartBytes = 2;

std::size_t number_at(std::string_view bytes, std::size_t at, std::size_t count) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < count; ++i)
    number |= std::size_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return number;
}

// CR and what may stand in lines of text.
bool begins_text(char c) { return (c >= ' ' && c < 127) || c == '\n' || c == '\r'; }

}  // namespace

bool ReplyStream::take(std::string_view bytes, const std::function<void(Reply&&)>& reply) {
  while (complaint_.empty()) {
    if (kept_.empty() && bytes.empty()) return true;
    const char first = kept_.empty() ? bytes.front() : kept_.front();
    const bool binary = first == kShort || first == kLong;
    if (!binary && !begins_text(first))
      complaint_ = fmt::format("not the combined API: a reply begins with the byte {:02X}; text is expected",
                               static_cast<unsigned char>(first));
    else if (!(binary ? take_binary(bytes, reply) : take_text(bytes, reply)))
      return complaint_.empty();
  }
  return false;
}

// Moves bytes over until `wanted` are kept; false where they do not suffice.
bool ReplyStream::fill(std::string_view& bytes, std::size_t wanted) {
  const auto count = std::min(wanted - kept_.size(), bytes.size());
  kept_.append(bytes.substr(0, count));
  bytes.remove_prefix(count);
  return kept_.size() == wanted;
}

// False where the reply is not complete.
bool ReplyStream::take_text(std::string_view& bytes, const std::function<void(Reply&&)>& reply) {
  const auto end = bytes.find('\r');
  const auto count = std::min(end, bytes.size());
  if (kept_.size() + count > kMostText) {
    kept_.append(bytes.substr(0, 40));
    complaint_ = fmt::format("not the combined API: '{}' goes on for more than {} bytes; a reply is expected",
                             excerpt(std::string_view(kept_).substr(0, 40)), kMostText);
    return false;
  }
  kept_.append(bytes.substr(0, count));
  bytes.remove_prefix(end == std::string_view::npos ? count : count + 1);
  if (end == std::string_view::npos) return false;
  Reply whole;
  whole.content = std::exchange(kept_, {});
  const auto length = whole.content.size() - std::min(kChecksumDigits, whole.content.size());
  const std::string_view words = std::string_view(whole.content).substr(0, length);
  whole.damaged = whole.content.substr(length) != fmt::format("{:04X}", checksum(words));
  if (!whole.damaged) whole.content.resize(length);  // else all of it, to be shown
  reply(std::move(whole));
  return true;
}

bool ReplyStream::take_binary(std::string_view& bytes, const std::function<void(Reply&&)>& reply) {
  if (header_ == 0) {
    if (kept_.size() < kStartBytes && !fill(bytes, kStartBytes)) return false;
    const std::size_t length_bytes = kept_[0] == kLong ? 4 : 2;
    const std::size_t before_checksum = kStartBytes + length_bytes;
    if (kept_[1] != kStart) {
      complaint_ = fmt::format(
          "not the combined API: a reply begins with the bytes {:02X} {:02X}; a start is expected",
          static_cast<unsigned char>(kept_[0]), static_cast<unsigned char>(kept_[1]));
      return false;
    }
    if (!fill(bytes, before_checksum + kChecksumBytes)) return false;
    if (number_at(kept_, before_checksum, kChecksumBytes) !=
        checksum(std::string_view(kept_).substr(0, before_checksum)))
      complaint_ = "a reply's header was changed on its way; its checksum is expected";
    else if (body_ = number_at(kept_, kStartBytes, length_bytes); body_ > kMostBody)
      complaint_ = fmt::format("a reply of {} bytes; at most {} are expected", body_, kMostBody);
    if (!complaint_.empty()) return false;
    header_ = std::exchange(kept_, kept_.substr(0, 1)).size();
  }
  // The first byte stays, so that what is kept tells what it belongs to.
  if (!fill(bytes, 1 + body_ + kChecksumBytes)) return false;
  Reply whole;
  whole.binary = true;
  whole.content = kept_.substr(1, body_);
  whole.damaged = number_at(kept_, 1 + body_, kChecksumBytes) != checksum(whole.content);
  kept_ = {};
  header_ = body_ = 0;
  reply(std::move(whole));
  return true;
}

}  // namespace palpate::drivers::ndi
