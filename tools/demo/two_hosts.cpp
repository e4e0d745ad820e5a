#include "tools/demo/two_hosts.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <linux/veth.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <thread>

namespace palpate::tools::demo {
namespace {

constexpr const char* kCable = "cable";  // either end of it, as tools that list interfaces show it

// A request to the kernel's networking, built attribute by attribute (rtnetlink(7)).
class LinkRequest {
 public:
  LinkRequest(std::uint16_t type, std::uint16_t flags) {
    header()->nlmsg_len = NLMSG_LENGTH(0);
    header()->nlmsg_type = type;
    header()->nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | NLM_F_ACK | flags);
  }
  void add(const void* data, std::size_t size) {
    std::memcpy(bytes_.data() + header()->nlmsg_len, data, size);
    header()->nlmsg_len = NLMSG_ALIGN(header()->nlmsg_len + static_cast<std::uint32_t>(size));
  }
  std::size_t open(std::uint16_t type) {
    const std::size_t at = header()->nlmsg_len;
    const rtattr attribute{.rta_len = RTA_LENGTH(0), .rta_type = type};
    add(&attribute, sizeof attribute);
    return at;
  }
  void close(std::size_t at) {
    const auto length = static_cast<unsigned short>(header()->nlmsg_len - at);
    std::memcpy(bytes_.data() + at + offsetof(rtattr, rta_len), &length, sizeof length);
  }
  void add(std::uint16_t type, const void* data, std::size_t size) {
    const auto at = open(type);
    add(data, size);
    close(at);
  }
  void add(std::uint16_t type, const char* text) { add(type, text, std::strlen(text) + 1); }

  // The kernel's answer: 0 or an errno.
  int ask() {
    const FileDescriptor socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
    if (!socket) return errno;
    alignas(nlmsghdr) std::array<char, 1024> answer{};
    ssize_t size = ::send(socket.get(), bytes_.data(), header()->nlmsg_len, 0);
    if (size >= 0) size = ::recv(socket.get(), answer.data(), answer.size(), 0);
    if (size < 0) return errno;
    if (static_cast<std::size_t>(size) < NLMSG_LENGTH(sizeof(nlmsgerr))) return EPROTO;
    return -reinterpret_cast<const nlmsgerr*>(answer.data() + NLMSG_HDRLEN)->error;
  }

 private:
  nlmsghdr* header() { return reinterpret_cast<nlmsghdr*>(bytes_.data()); }
  alignas(nlmsghdr) std::array<char, 512> bytes_{};
};

ifreq cable_request() {
  ifreq request{};
  std::strncpy(request.ifr_name, kCable, IFNAMSIZ - 1);
  return request;
}

Expected<void> configure(int socket, unsigned long what, ifreq request) {
  if (::ioctl(socket, what, &request) == 0) return {};
  return refused("two hosts: the cable's end cannot be configured ({})", std::strerror(errno));
}

sockaddr address_of(const char* text) {
  sockaddr_in internet{};
  internet.sin_family = AF_INET;
  ::inet_pton(AF_INET, text, &internet.sin_addr);
  sockaddr address{};
  std::memcpy(&address, &internet, sizeof address);
  return address;
}

Expected<void> set_end(int socket, bool up) {
  ifreq request = cable_request();
  request.ifr_flags = up ? IFF_UP : 0;
  return configure(socket, SIOCSIFFLAGS, request);
}

}  // namespace

Expected<TwoHosts> TwoHosts::make() {
  TwoHosts hosts;
  for (const Host host : {kPhysicsHost, kGraphicsHost})
    if (auto made = hosts.make_network(host); !made) return tl::unexpected(made.error());
  if (auto laid = hosts.lay_cable(); !laid) return tl::unexpected(laid.error());
  for (const Host host : {kPhysicsHost, kGraphicsHost})
    if (auto ready = hosts.set_up(host); !ready) return tl::unexpected(ready.error());
  return hosts;
}

// A network belongs to a thread; a thread made for it is the only one that has to leave ours.
Expected<void> TwoHosts::make_network(Host host) {
  int failure = 0;
  std::thread([&] {
    if (::unshare(CLONE_NEWNET) != 0) {
      failure = errno;
      return;
    }
    networks_[host] = FileDescriptor(::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC));
    sockets_[host] = FileDescriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (networks_[host].get() < 0 || sockets_[host].get() < 0) failure = errno;
  }).join();
  if (failure == EPERM)
    return refused(
        "two hosts: this user may not make networks ({}); run it as root, or put `unshare "
        "--map-current-user --keep-caps` in front",
        std::strerror(failure));
  if (failure != 0)
    return refused("two hosts: no network of their own can be made here ({}); Linux namespaces are needed",
                   std::strerror(failure));
  return {};
}

Expected<void> TwoHosts::lay_cable() {
  int failure = 0;
  const auto asked = at(kPhysicsHost, [&] {
    LinkRequest request(RTM_NEWLINK, NLM_F_CREATE | NLM_F_EXCL);
    const ifinfomsg any{};
    request.add(&any, sizeof any);
    request.add(IFLA_IFNAME, kCable);
    const auto info = request.open(IFLA_LINKINFO);
    request.add(IFLA_INFO_KIND, "veth");
    const auto data = request.open(IFLA_INFO_DATA);
    const auto other_end = request.open(VETH_INFO_PEER);
    request.add(&any, sizeof any);
    request.add(IFLA_IFNAME, kCable);
    const int there = networks_[kGraphicsHost].get();
    request.add(IFLA_NET_NS_FD, &there, sizeof there);
    request.close(other_end);
    request.close(data);
    request.close(info);
    failure = request.ask();
  });
  if (!asked) return asked;
  if (failure != 0)
    return refused("two hosts: no cable can be laid between them ({}); the kernel's `veth` is needed",
                   std::strerror(failure));
  return {};
}

Expected<void> TwoHosts::set_up(Host host) {
  const int socket = sockets_[host].get();
  ifreq request = cable_request();
  request.ifr_addr = address_of(kPlaces[host]);
  if (auto done = configure(socket, SIOCSIFADDR, request); !done) return done;
  request.ifr_netmask = address_of("255.255.255.252");
  if (auto done = configure(socket, SIOCSIFNETMASK, request); !done) return done;
  return set_end(socket, true);
}

Expected<void> TwoHosts::at(Host host, const std::function<void()>& work) const {
  int failure = 0;
  std::thread([&] {
    if (::setns(networks_[host].get(), CLONE_NEWNET) == 0)
      work();
    else
      failure = errno;
  }).join();
  if (failure != 0) return refused("two hosts: no way into their network ({})", std::strerror(failure));
  return {};
}

Expected<void> TwoHosts::plug(bool in) const { return set_end(sockets_[kPhysicsHost].get(), in); }

}  // namespace palpate::tools::demo
