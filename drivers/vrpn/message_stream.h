// Messages out of a stream of bytes that comes in any pieces, version first. Pure: no sockets, no clock. One thread.
//
// The stream is lost where it is not VRPN, or announces more than can be meant: whoever reads it should close the
// connection. A message that cannot be right is the reader's to count.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/vrpn/codec.h"

namespace palpate::drivers::vrpn {

class MessageStream {
 public:
  // Takes all of the bytes; `message` is called for each message they complete. False: the stream is lost,
  // now or before, and nothing more will come.
  bool take(std::string_view bytes, const std::function<void(Message&&)>& message);

  bool greeted() const { return greeted_; }  // the other side's version has come, and is ours
  // Why the stream is lost; empty where it is not.
  const std::string& complaint() const { return complaint_; }

 private:
  bool fill(std::string_view& bytes, std::size_t wanted);
  void lose(const Error& error);

  std::string kept_;
  std::optional<Header> header_;  // whose payload is awaited
  bool greeted_ = false;
  std::string complaint_;
};

}  // namespace palpate::drivers::vrpn
