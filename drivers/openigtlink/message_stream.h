// Messages out of a stream of bytes that comes in any pieces. Pure: no sockets, no clock. One thread.
//
// A message of a kind that is read is kept until it is complete, at most kMostBodyBytes; of other kinds
// (images, say) the body is passed over as it comes and nothing of it is kept. A message that is damaged or
// makes no sense is counted and left out; the stream goes on behind it. Where the header itself is none, or
// announces more than can be meant, there is no telling where the next message begins: the stream is lost,
// and whoever reads it should close the connection.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/openigtlink/codec.h"

namespace palpate::drivers::openigtlink {

// A single message of a kind that is not read may be this long (an uncompressed volume).
inline constexpr std::uint64_t kMostSkippedBytes = std::uint64_t{1} << 32;

class MessageStream {
 public:
  struct Counts {
    std::uint64_t messages = 0;  // handed over
    std::uint64_t bad_crc = 0;   // refused: damaged on the way
    std::uint64_t refused = 0;   // refused: undamaged, but it makes no sense
    std::uint64_t skipped = 0;   // of kinds that are not read
  };

  // Takes all of the bytes; `message` is called for each message they complete. False: the stream is lost,
  // now or before, and nothing more will come.
  bool take(std::string_view bytes, const std::function<void(Message&&)>& message);

  const Counts& counts() const { return counts_; }
  // Why the newest message was refused or the stream lost; empty where neither has happened.
  const std::string& complaint() const { return complaint_; }

 private:
  bool fill(std::string_view& bytes, std::size_t wanted);
  bool begin_message();
  void end_message(const std::function<void(Message&&)>& message);

  std::string kept_;              // of the header or the body that is not complete yet
  std::optional<Header> header_;  // whose body is awaited
  std::uint64_t to_skip_ = 0;
  bool lost_ = false;
  std::string complaint_;
  Counts counts_;
};

}  // namespace palpate::drivers::openigtlink
