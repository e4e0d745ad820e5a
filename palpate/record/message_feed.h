// The messages of a recording one after the other, for who takes them at a pace of his own: a scan in a thread of its own that waits
// where it is too far ahead.
//
// One thread takes. Memory: 4096 messages or 32 MiB, and one more. An error of the file shows at the end, in result().
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "palpate/record/byte_source.h"
#include "palpate/record/mcap_reader.h"

namespace palpate::record {

class MessageFeed : private ScanHandler {
 public:
  struct Item {
    Channel channel;
    std::optional<Schema> schema;
    Message message;  // without its data
    std::string data;
  };

  MessageFeed(std::unique_ptr<ByteSource> source, ScanOptions options);
  ~MessageFeed() override;
  MessageFeed(const MessageFeed&) = delete;
  MessageFeed& operator=(const MessageFeed&) = delete;

  // The next one, or null where there is none any more; the same until take(). Waits for the file.
  const Item* next();
  // The same, but does not wait: null as well where none has been read yet.
  const Item* ready();
  void take();
  // There is none any more.
  bool over();
  // Once next() is null.
  const Expected<void>& result() const { return result_; }

 private:
  Expected<void> message(const HeardMessage& heard) override;
  void run();

  std::unique_ptr<ByteSource> source_;
  ScanOptions options_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> items_;  // a deque: the front stays where it is while others are added
  std::size_t waiting_bytes_ = 0;
  bool over_ = false, abandoned_ = false;
  Expected<void> result_{};
  std::thread thread_;
};

}  // namespace palpate::record
