#include "palpate/transport/internal/connections.h"

#include <algorithm>
#include <utility>

namespace palpate::transport {

void Connections::began(int listener, int descriptor, std::uint64_t number, std::string source,
                        Instant<PhysicsClock> now) {
  connections_[descriptor] = {listener, number, std::move(source), {}, now};
}

void Connections::ended(int listener, int descriptor) {
  const auto found = connections_.find(descriptor);
  if (found != connections_.end() && found->second.listener == listener) connections_.erase(found);
}

std::size_t Connections::of_user(const std::string& user) const {
  return static_cast<std::size_t>(std::count_if(connections_.begin(), connections_.end(),
                                                [&](const auto& one) { return one.second.user == user; }));
}

// A third at least is for those that have spoken, however few places there are.
std::size_t Connections::most_new() const { return std::min(kMostNew, places_ / 3 + 1); }

std::size_t Connections::for_operators() const { return std::min(kForOperators, places_ / 8); }

bool Connections::is_of(int descriptor, const std::string& key) const {
  const auto found = connections_.find(descriptor);
  if (found == connections_.end() || found->second.user.empty()) return false;
  return found->second.user == (key.empty() ? found->second.source : key);
}

bool Connections::heard(int descriptor, const std::string& key, bool by_operator) {
  const auto found = connections_.find(descriptor);
  if (found == connections_.end()) return false;  // ended meanwhile
  if (is_of(descriptor, key)) return true;
  Connection& connection = found->second;
  const std::string& user = key.empty() ? connection.source : key;
  connection.user.clear();  // a message of who had this descriptor before may have named another
  const std::size_t known = size() - of_user({});
  const std::size_t kept = most_new() + (by_operator ? 0 : for_operators());
  if (known + kept >= places_ || of_user(user) >= (key.empty() ? kMostOfSource : kMostOfKey)) return false;
  connection.user = user;
  return true;
}

std::optional<Connections::Ended> Connections::take(int descriptor, const std::string& key) {
  const auto found = connections_.find(descriptor);
  if (found == connections_.end()) return std::nullopt;
  const auto& [at, connection] = *found;
  if (!connection.user.empty() && !is_of(descriptor, key)) return std::nullopt;
  const Ended one{at, connection.number};
  connections_.erase(found);
  return one;
}

std::vector<Connections::Ended> Connections::of_listener(int listener) const {
  std::vector<Ended> found;
  for (const auto& [descriptor, connection] : connections_)
    if (connection.listener == listener) found.push_back({descriptor, connection.number});
  return found;
}

// Of the source that has most new connections the one that has been new for longest.
Connections::Entry Connections::one_too_many() {
  std::map<std::string, std::pair<std::size_t, Entry>> sources;
  for (Entry one = connections_.begin(); one != connections_.end(); ++one) {
    if (!one->second.user.empty()) continue;
    auto& [count, oldest] = sources.try_emplace(one->second.source, 0, one).first->second;
    ++count;
    if (one->second.since < oldest->second.since) oldest = one;
  }
  return std::max_element(sources.begin(), sources.end(),
                          [](const auto& a, const auto& b) { return a.second.first < b.second.first; })
      ->second.second;
}

std::vector<Connections::Ended> Connections::take_overdue(Instant<PhysicsClock> now) {
  std::vector<Ended> overdue;
  std::size_t still_new = of_user({});
  const auto take = [&](Entry one) {
    overdue.push_back({one->first, one->second.number});
    --still_new;
    return connections_.erase(one);
  };
  const Duration patience = still_new > kFewNew ? kNewForAmongMany : kNewFor;
  for (Entry one = connections_.begin(); one != connections_.end();)
    one = one->second.user.empty() && now - one->second.since > patience ? take(one) : std::next(one);
  while (still_new > most_new() || (still_new > 0 && size() > places_)) take(one_too_many());
  return overdue;
}

}  // namespace palpate::transport
