#include "palpate/record/message_feed.h"

#include <utility>

namespace palpate::record {
namespace {

constexpr std::size_t kMostItems = 4096, kMostBytes = 32 * 1024 * 1024;

}  // namespace

MessageFeed::MessageFeed(std::unique_ptr<ByteSource> source, ScanOptions options)
    : source_(std::move(source)), options_(std::move(options)), thread_([this] { run(); }) {}

MessageFeed::~MessageFeed() {
  {
    const std::lock_guard lock(mutex_);
    abandoned_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

const MessageFeed::Item* MessageFeed::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return over_ || !items_.empty(); });
  return items_.empty() ? nullptr : &items_.front();
}

const MessageFeed::Item* MessageFeed::ready() {
  const std::lock_guard lock(mutex_);
  return items_.empty() ? nullptr : &items_.front();
}

bool MessageFeed::over() {
  const std::lock_guard lock(mutex_);
  return over_ && items_.empty();
}

void MessageFeed::take() {
  const std::lock_guard lock(mutex_);
  waiting_bytes_ -= items_.front().data.size();
  items_.pop_front();
  changed_.notify_all();
}

Expected<void> MessageFeed::message(const HeardMessage& heard) {
  Item item{heard.channel, heard.schema == nullptr ? std::nullopt : std::optional(*heard.schema),
            heard.message, std::string(heard.message.data)};
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] {
    return abandoned_ || items_.empty() || (items_.size() < kMostItems && waiting_bytes_ < kMostBytes);
  });
  if (abandoned_) return refused(ErrorCode::stopped, "");
  waiting_bytes_ += item.data.size();
  items_.push_back(std::move(item));
  changed_.notify_all();
  return {};
}

void MessageFeed::run() {
  const auto scanned = scan(*source_, options_, *this);
  const std::lock_guard lock(mutex_);
  if (!scanned) result_ = tl::unexpected(scanned.error());
  over_ = true;
  changed_.notify_all();
}

}  // namespace palpate::record
