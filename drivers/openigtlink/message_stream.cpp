#include "drivers/openigtlink/message_stream.h"

#include <algorithm>

namespace palpate::drivers::openigtlink {

bool MessageStream::take(std::string_view bytes, const std::function<void(Message&&)>& message) {
  while (!lost_) {
    if (to_skip_ > 0) {
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(to_skip_, bytes.size()));
      bytes.remove_prefix(count);
      to_skip_ -= count;
      if (to_skip_ > 0) return true;
    }
    if (!header_) {
      if (!fill(bytes, kHeaderBytes)) return true;
      lost_ = !begin_message();
    } else {
      if (!fill(bytes, static_cast<std::size_t>(header_->body_bytes))) return true;
      end_message(message);
    }
  }
  return false;
}

// Moves bytes over until `wanted` are kept; false where they do not suffice.
bool MessageStream::fill(std::string_view& bytes, std::size_t wanted) {
  const auto count = std::min(wanted - kept_.size(), bytes.size());
  kept_.append(bytes.substr(0, count));
  bytes.remove_prefix(count);
  return kept_.size() == wanted;
}

bool MessageStream::begin_message() {
  auto header = decode_header(kept_);
  kept_.clear();
  if (!header) {
    complaint_ = header.error().message;
    return false;
  }
  const bool known = is_known(*header);
  const std::uint64_t most = known ? kMostBodyBytes : kMostSkippedBytes;
  if (header->body_bytes > most) {
    complaint_ = fmt::format("{} of '{}': a body of {} bytes; at most {} are expected", header->type,
                             header->device, header->body_bytes, most);
    return false;
  }
  if (known) {
    header_ = std::move(*header);
  } else {
    to_skip_ = header->body_bytes;
    ++counts_.skipped;
  }
  return true;
}

void MessageStream::end_message(const std::function<void(Message&&)>& message) {
  auto decoded = decode_body(*header_, kept_);
  if (decoded) {
    ++counts_.messages;
  } else {
    ++(crc_agrees(*header_, kept_) ? counts_.refused : counts_.bad_crc);
    complaint_ = decoded.error().message;
  }
  header_.reset();
  kept_.clear();
  if (kept_.capacity() > 1 << 16) kept_.shrink_to_fit();  // one large message should not stay for good
  if (decoded) message(std::move(*decoded));
}

}  // namespace palpate::drivers::openigtlink
