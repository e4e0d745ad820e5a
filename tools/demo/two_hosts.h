// Two hosts on one machine, each with a network of its own, and a cable between them that can be pulled.
//
// Linux network namespaces joined by a veth pair; nothing but the network is split. The namespaces have no
// names: they last as long as this object or a process in them and then go with their cable, however either
// ended. One thread.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>

#include "palpate/core/expected.h"
#include "palpate/core/file_descriptor.h"

namespace palpate::tools::demo {

class TwoHosts {
 public:
  enum Host : std::size_t { kPhysicsHost, kGraphicsHost };
  // Their places in the network between them, of a range set aside for examples (RFC 5737).
  static constexpr std::array<const char*, 2> kPlaces{"192.0.2.1", "192.0.2.2"};

  // With the cable plugged in. Refused where this process may not make networks, with what to do.
  static Expected<TwoHosts> make();

  // Calls `work` on the host, and returns when it has ended. Processes started there stay there.
  Expected<void> at(Host host, const std::function<void()>& work) const;

  // Pulls the cable out of the physics host, or plugs it in again.
  Expected<void> plug(bool in) const;

 private:
  TwoHosts() = default;
  Expected<void> make_network(Host host);
  Expected<void> lay_cable();
  Expected<void> set_up(Host host);

  std::array<FileDescriptor, 2> networks_;  // the namespaces
  std::array<FileDescriptor, 2> sockets_;   // of each network, to configure it
};

}  // namespace palpate::tools::demo
