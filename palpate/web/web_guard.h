// Who may talk to a page of this machine, by the headers of a request. Values; any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::web {

// What a header Host says: the name without the port, in lower-case letters, brackets of an IPv6 address taken off.
// Empty: it is none.
std::string host_name(std::string_view host);

// Whether an address is of this machine alone: 127.0.0.1, ::1, localhost.
bool is_loopback(std::string_view host);

class WebGuard {
 public:
  // As one of the hosts: whoever calls it by its number. Nobody can point a number at it.
  static constexpr const char* kAnyNumber = "*";

  WebGuard(std::string_view address, std::vector<std::string> hosts, std::vector<std::string> origins);

  // Against names that are pointed at this machine by others (DNS rebinding).
  bool admits_host(std::string_view host) const;
  // Against pages of others in the same browser. `origin` empty: the header is not there. A page's own is the Host that
  // it was asked from, of whatever port: a tunnel may begin at another.
  bool admits_origin(std::string_view origin, std::string_view host) const;

 private:
  std::vector<std::string> hosts_, origins_;
};

}  // namespace palpate::web
