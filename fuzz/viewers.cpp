// What a browser or a viewer says to the console: a header Host, an Origin, then texts, a line each. Nobody is let in who
// should not be, and what is subscribed to is a channel that there is.
#include <string>

#include "fuzz/check.h"
#include "palpate/web/web_guard.h"
#include "tools/console/page_messages.h"
#include "tools/console/token.h"
#include "tools/console/viewer_talk.h"

namespace palpate::fuzz {
namespace {

namespace console = tools::console;

std::string_view take_line(std::string_view& rest) {
  const auto end = rest.find('\n');
  const auto line = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return line;
}

}  // namespace

Refusals viewers(std::string_view file) {
  Refusals refusals;
  const web::WebGuard guard("127.0.0.1", {}, {"https://viewer.example"});
  const std::string host(take_line(file)), origin(take_line(file));
  const auto name = web::host_name(host);
  hold(guard.admits_host(host) == (name == "localhost" || name == "127.0.0.1" || name == "::1"),
       "it answers to this machine's names alone");
  if (!origin.empty() && guard.admits_origin(origin, host))
    hold(origin.size() == host.size() + 7 || origin.size() == std::string("https://viewer.example").size(),
         "an origin is the page's own, or one that was allowed");
  console::ViewerTalk talk;
  while (!file.empty()) {
    const auto line = take_line(file);
    if (const auto done = talk.take(line); !done) refusals.push_back(done.error().message);
    const auto said = console::read_page_message(line);
    hold(said.seen_ns >= 0, "a time that was seen is one");
    hold(said.token != "token" || console::same_token(said.token, "token"), "a token is itself");
    hold(!console::holds_token(line, ""), "nobody has a token that was not made");
  }
  for (std::size_t i = 1; i <= console::viewer_channels().size(); ++i) {
    const auto channel = static_cast<console::Channel>(i);
    const auto wrapped = talk.wrap(channel, 1, "message");
    hold(talk.wants(channel) == !wrapped.empty(), "what is wanted is sent");
    hold(wrapped.size() <= console::ViewerTalk::kMostSubscriptions, "subscriptions are bounded");
  }
  for (const auto& refusal : refusals) hold_one_line({Error::Kind::refused, refusal});
  return refusals;
}

}  // namespace palpate::fuzz
