#include "tools/doctor/doctor_network.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/laboratory/channel.h"
#include "palpate/core/file_descriptor.h"
#include "palpate/core/run_directory.h"

namespace palpate::tools::doctor {
namespace {

namespace fs = std::filesystem;

// A server that has stopped for a moment answers within this; one that has hung does not.
constexpr double kAnswerPatienceS = 3.0;

unsigned mode_of(const fs::path& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 ? info.st_mode & 07777u : 0u;
}

// Why no socket can be made in this folder: makes one under a name of its own and removes it.
std::string why_no_socket(const fs::path& folder) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = folder / ("d" + std::to_string(::getpid()));
  if (path.size() >= sizeof address.sun_path) return "";  // the path's length is told by itself
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const FileDescriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!fd) return std::strerror(errno);
  std::string reason;
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    ::unlink(path.c_str());
  } else {
    reason = std::strerror(errno);
  }
  return reason;
}

void look_into(const fs::path& folder, SocketFacts& facts) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const fs::path& path = entry.path();
    if (entry.is_socket(ignored) && !transport::somebody_listens(path))
      facts.leftovers.push_back(path.filename());
    if (path.extension() != ".lab") continue;
    (drivers::laboratory::LabClient::open(path.stem()) ? facts.laboratories : facts.leftovers)
        .push_back(path.stem());
  }
  std::sort(facts.leftovers.begin(), facts.leftovers.end());
  std::sort(facts.laboratories.begin(), facts.laboratories.end());
}

// Who answers at an encrypted address that is expected to have this key.
transport::Answered who_answers_as(const std::string& address, const std::string& key, const fs::path& keys) {
  const auto place = transport::parse_endpoint(address, transport::EndpointUse::connect);
  if (!place) return transport::Answered{transport::Answer::stranger, {}, place.error().message};
  const auto pair = transport::read_key_pair(keys);
  if (!pair) return transport::Answered{transport::Answer::stranger, {}, pair.error().message};
  auto answered = transport::who_answers(*place, transport::ClientIdentity{*pair, key}, kAnswerPatienceS);
  return answered ? *answered
                  : transport::Answered{transport::Answer::stranger, {}, answered.error().message};
}

// Who answers at an address that a server listens at, asked with the keys of the server's own machine.
transport::Answered who_is_there(const transport::Endpoint& listening, const fs::path& keys) {
  std::string address = listening.address;
  if (!listening.local()) {
    const auto port = address.substr(address.rfind(':'));
    const auto host = address.substr(6, address.size() - 6 - port.size());
    if (host == "*" || host == "0.0.0.0") address = "tcp://127.0.0.1" + port;
  }
  if (listening.encrypted) {
    const auto pair = transport::read_key_pair(keys);
    if (!pair) return transport::Answered{transport::Answer::stranger, {}, pair.error().message};
    return who_answers_as(address, pair->public_key, keys);
  }
  auto answered = transport::who_answers(listening, {}, kAnswerPatienceS);
  return answered ? *answered
                  : transport::Answered{transport::Answer::stranger, {}, answered.error().message};
}

}  // namespace

KeyFacts key_facts(const fs::path& chosen) {
  KeyFacts facts;
  facts.encryption = transport::network_libraries().curve;
  const auto folder = chosen.empty() ? transport::keys_folder() : Expected<fs::path>(chosen);
  if (!folder) {
    facts.folder_problem = folder.error().message;
    return facts;
  }
  facts.folder = *folder;
  facts.folder_mode = mode_of(*folder);
  std::error_code ignored;
  facts.pair_there = fs::exists(*folder / "secret_key", ignored);
  if (const auto pair = transport::read_key_pair(*folder)) {
    facts.public_key = pair->public_key;
  } else {
    facts.pair_problem = pair.error().message;
  }
  if (auto admitted = transport::read_authorized_keys(*folder)) {
    facts.admitted = std::move(admitted->keys);
    facts.complaints = std::move(admitted->complaints);
  } else {
    facts.admitted_problem = admitted.error().message;
  }
  if (const auto servers = transport::read_known_servers(*folder)) {
    for (const auto& [address, key] : *servers)
      facts.servers.push_back({address, who_answers_as(address, key, *folder)});
  } else {
    facts.servers_problem = servers.error().message;
  }
  return facts;
}

SocketFacts socket_facts() {
  SocketFacts facts;
  facts.folder = run_directory_place();
  facts.path_bytes = (facts.folder / "physics.sock").native().size();
  facts.path_limit = sizeof(sockaddr_un{}.sun_path) - 1;
  struct stat info {};
  facts.exists = lstat(facts.folder.c_str(), &info) == 0;
  if (!facts.exists) {
    if (access(facts.folder.parent_path().c_str(), W_OK | X_OK) != 0)
      facts.socket_problem = fmt::format("{}: {}", facts.folder.parent_path().string(), std::strerror(errno));
    return facts;
  }
  facts.mode = info.st_mode & 07777u;
  if (const auto own = check_private_directory(facts.folder); !own) {
    facts.folder_problem = own.error().message;
    return facts;
  }
  facts.socket_problem = why_no_socket(facts.folder);
  look_into(facts.folder, facts);
  // The folder is there and ours, so this makes nothing.
  if (const auto endpoint = transport::default_endpoint(); endpoint)
    if (const auto answered = transport::who_answers(*endpoint, {}, kAnswerPatienceS); answered)
      facts.at_default = *answered;
  return facts;
}

Expected<std::optional<ListenFacts>> listen_facts(const std::string& address, KeyFacts& keys) {
  if (address.empty()) return std::nullopt;
  ListenFacts facts;
  facts.address = address;
  const auto endpoint = transport::parse_endpoint(address, transport::EndpointUse::listen);
  if (!endpoint) {
    // A folder that is not fit for sockets is what a doctor is for; an address that means nothing is not.
    if (!address.starts_with("ipc://")) return tl::unexpected(endpoint.error());
    facts.problem = endpoint.error().message;
    return facts;
  }
  keys.needed = endpoint->encrypted;
  facts.local = endpoint->local();
  std::error_code ignored;
  if (facts.local && fs::exists(endpoint->socket, ignored) && !fs::is_socket(endpoint->socket, ignored)) {
    facts.problem = fmt::format("{}: exists and is not a socket; remove it or listen at another address",
                                endpoint->socket.string());
    return facts;
  }
  if (!facts.local) facts.listening = transport::can_listen(*endpoint);
  if (facts.local || facts.listening.in_use) facts.answered = who_is_there(*endpoint, keys.folder);
  return facts;
}

}  // namespace palpate::tools::doctor
