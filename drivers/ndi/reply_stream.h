// Replies out of a stream of bytes that comes in any pieces. Pure: no sockets, no clock. One thread.
//
// A reply that was changed on its way is handed over as such. The stream is lost where a reply begins as none does, has a
// damaged header, or announces more than can be meant: there is no telling where the next one begins, and whoever reads it
// should close the connection.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "drivers/ndi/codec.h"

namespace palpate::drivers::ndi {

inline constexpr std::size_t kMostText = 8192;     // bytes of a reply of text, checksum included
inline constexpr std::size_t kMostBody = 1 << 20;  // of a binary one

struct Reply {
  bool binary = false;
  bool damaged = false;  // its checksum is not its own
  std::string content;   // without header, checksum and CR
};

class ReplyStream {
 public:
  // Takes all of the bytes; `reply` is called for each reply they complete. False: the stream is lost, now or before, and
  // nothing more will come.
  bool take(std::string_view bytes, const std::function<void(Reply&&)>& reply);

  // Why the stream is lost; empty where it is not.
  const std::string& complaint() const { return complaint_; }

 private:
  bool fill(std::string_view& bytes, std::size_t wanted);
  bool take_text(std::string_view& bytes, const std::function<void(Reply&&)>& reply);
  bool take_binary(std::string_view& bytes, const std::function<void(Reply&&)>& reply);

  std::string kept_;
  std::size_t header_ = 0, body_ = 0;  // bytes of the binary reply that has begun; no header: not yet known
  std::string complaint_;
};

}  // namespace palpate::drivers::ndi
