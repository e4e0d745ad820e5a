// The channels of one recording in a copy of it: each is added with its schema where its first message comes. Private to the
// module.
#pragma once

#include <cstdint>
#include <map>

#include "palpate/record/mcap_reader.h"
#include "palpate/record/mcap_writer.h"

namespace palpate::record {

class ChannelNumbers {
 public:
  // In the copy.
  Expected<std::uint16_t> of(const Channel& channel, const Schema* schema, std::uint16_t number,
                             McapWriter& writer) {
    const auto known = known_.find(number);
    if (known != known_.end() && known->second.told == channel) return known->second.number;
    Channel copied = channel;
    copied.schema = 0;
    if (schema != nullptr) {
      const auto added = writer.add_schema(*schema);
      if (!added) return added;
      copied.schema = *added;
    }
    const auto added = writer.add_channel(copied);
    if (added) known_[number] = {channel, *added};
    return added;
  }

 private:
  struct Known {
    Channel told;  // in the original
    std::uint16_t number = 0;
  };
  std::map<std::uint16_t, Known> known_;  // by the number in the original
};

}  // namespace palpate::record
