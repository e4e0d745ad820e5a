// The messages that wait for one client. Full, it loses the oldest that has not begun to leave: what has
// begun must be finished, or the client could not find the next one. One thread.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace palpate::drivers::network {

class SendQueue {
 public:
  using Bytes = std::shared_ptr<const std::string>;  // one message, shared by the queues of all clients

  // False where the oldest was lost for it. `most` is at least 2.
  bool push(Bytes message, std::size_t most) {
    waiting_.push_back(std::move(message));
    if (waiting_.size() <= most) return true;
    waiting_.erase(waiting_.begin() + (sent_of_first_ > 0 ? 1 : 0));
    return false;
  }
  bool empty() const { return waiting_.empty(); }
  // What has to leave next; not for an empty queue.
  std::string_view next() const { return std::string_view(*waiting_.front()).substr(sent_of_first_); }
  // So many bytes of next() have left; true where that ends a message.
  bool sent(std::size_t bytes) {
    sent_of_first_ += bytes;
    if (sent_of_first_ < waiting_.front()->size()) return false;
    waiting_.pop_front();
    sent_of_first_ = 0;
    return true;
  }

 private:
  std::deque<Bytes> waiting_;
  std::size_t sent_of_first_ = 0;  // bytes
};

}  // namespace palpate::drivers::network
