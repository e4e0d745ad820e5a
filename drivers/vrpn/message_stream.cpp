#include "drivers/vrpn/message_stream.h"

#include <algorithm>

namespace palpate::drivers::vrpn {

bool MessageStream::take(std::string_view bytes, const std::function<void(Message&&)>& message) {
  while (complaint_.empty()) {
    if (!greeted_) {
      if (!fill(bytes, kCookieBytes)) return true;
      if (const auto fine = check_cookie(kept_); !fine) lose(fine.error());
      greeted_ = complaint_.empty();
      kept_.clear();
    } else if (!header_) {
      if (!fill(bytes, kHeaderBytes)) return true;
      auto header = decode_header(kept_);
      kept_.clear();
      if (!header)
        lose(header.error());
      else
        header_ = *header;
    } else {
      if (!fill(bytes, header_->padded())) return true;
      kept_.resize(header_->payload_bytes);
      Message whole{header_->stamp, header_->sender, header_->type, std::move(kept_)};
      header_.reset();
      kept_ = {};
      message(std::move(whole));
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

void MessageStream::lose(const Error& error) { complaint_ = error.message; }

}  // namespace palpate::drivers::vrpn
