// The part of doctor_facts.h that concerns sockets, addresses and keys. Private to it.
#pragma once

#include "tools/doctor/doctor_facts.h"

namespace palpate::tools::doctor {

KeyFacts key_facts(const std::filesystem::path& chosen);
SocketFacts socket_facts();
// Nothing where no address is given; says in `keys` whether it needs them. Wrong use: no address at all.
Expected<std::optional<ListenFacts>> listen_facts(const std::string& address, KeyFacts& keys);

}  // namespace palpate::tools::doctor
