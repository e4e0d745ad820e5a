#include "palpate/sim/gesture_lines.h"

#include <poll.h>
#include <unistd.h>

#include <array>

#include "palpate/device/person_json.h"

namespace palpate::sim {

void GestureLines::look(device::Person& person) {
  std::array<char, 1024> some{};
  pollfd input{in_, POLLIN, 0};
  if (in_ >= 0 && poll(&input, 1, 0) > 0) {
    const auto got = read(in_, some.data(), some.size());
    if (got <= 0) in_ = -1;
    for (ssize_t i = 0; i < got; ++i) {
      const char byte = some[static_cast<std::size_t>(i)];
      if (byte == '\n') {
        begin(line_, person);
        line_.clear();
      } else if (line_.size() < kLongestLine) {
        line_ += byte;
      }
    }
  }
  if (doing_.empty()) return;
  const auto there = person.ready();
  if (!there || !*there) return;
  answer({{"ready", doing_}});
  doing_.clear();
}

void GestureLines::begin(const std::string& line, device::Person& person) {
  const Json json = Json::parse(line, nullptr, false);
  const auto request = device::request_of(json);
  if (!request) return answer({{"refused", request.error().message}, {"no_more", false}});
  const auto asked = person.ask(*request);
  if (!asked)
    return answer(
        {{"refused", asked.error().message}, {"no_more", asked.error().code == ErrorCode::no_more}});
  doing_ = device::name_of(request->gesture);
}

void GestureLines::answer(const Json& json) {
  std::fprintf(out_, "%s\n", json.dump().c_str());
  std::fflush(out_);
}

}  // namespace palpate::sim
