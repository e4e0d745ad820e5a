#include "palpate/transport/local_endpoint.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "palpate/core/file_lock.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/system_error.h"
#include "palpate/core/text.h"

namespace palpate::transport {

namespace {

constexpr std::size_t kMaxSocketPath = sizeof(sockaddr_un{}.sun_path) - 1;  // 107 bytes

std::string shown(std::string_view address) { return excerpt(address, 160); }
std::string reason() { return reason_of(errno); }

bool exists(const std::filesystem::path& path, struct stat& info) { return lstat(path.c_str(), &info) == 0; }

// Ours, no link, and nobody else may write there.
Expected<void> check_folder(const std::filesystem::path& folder) {
  struct stat info {};
  if (!exists(folder, info))
    return wrong_use("{}: {}; make the folder first", shown(folder.string()), reason());
  if (!S_ISDIR(info.st_mode))
    return wrong_use("{}: not a folder; servers meet in a folder of their user", shown(folder.string()));
  if (info.st_uid != geteuid()) {
    return wrong_use("{}: belongs to user {}, not to {}; sockets must lie in a folder of your own",
                     shown(folder.string()), info.st_uid, geteuid());
  }
  if ((info.st_mode & S_ISVTX) != 0)
    return wrong_use("{}: everybody's (mode {:o}); choose a folder of your own", shown(folder.string()),
                     info.st_mode & 07777);
  if ((info.st_mode & 0022) != 0)
    return wrong_use("{}: others can write to it (mode {:o}); chmod 700 it", shown(folder.string()),
                     info.st_mode & 07777);
  return {};
}

Expected<void> check_length(const std::filesystem::path& socket) {
  const std::size_t length = socket.native().size();
  if (length <= kMaxSocketPath) return {};
  return wrong_use("{}: {} bytes, a unix socket's path has at most {}; choose a shorter one",
                   shown(socket.string()), length, kMaxSocketPath);
}

Expected<Endpoint> parse_ipc(std::string_view path_text, bool insecure) {
  if (path_text.empty() || path_text.front() == '@' || path_text == "*") {
    return wrong_use(
        "ipc://{}: needs the path of a socket file, such as ipc:///run/user/1000/palpate/physics.sock",
        shown(path_text));
  }
  std::error_code error;
  const std::filesystem::path socket = std::filesystem::absolute(path_text, error).lexically_normal();
  if (error || !socket.has_filename())
    return wrong_use("ipc://{}: not the path of a socket file", shown(path_text));
  if (auto length = check_length(socket); !length) return tl::unexpected(length.error());
  if (!insecure) {
    std::filesystem::path folder = std::filesystem::canonical(socket.parent_path(), error);
    if (error) folder = socket.parent_path();
    if (auto own = check_folder(folder); !own) {
      return wrong_use("{} (or take the risk with --insecure)", own.error().message);
    }
  }
  return Endpoint{"ipc://" + socket.string(), socket, false};
}

Expected<Endpoint> parse_tcp(std::string_view text, EndpointUse use, bool insecure) {
  const std::string_view rest = text.substr(6);
  const std::size_t colon = rest.rfind(':');
  const std::string_view host = rest.substr(0, colon == std::string_view::npos ? 0 : colon);
  std::string_view port_text = colon == std::string_view::npos ? std::string_view() : rest.substr(colon + 1);
  if (port_text == "*") port_text = "0";
  int port = -1;
  const auto parsed = std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  const bool number = parsed.ec == std::errc() && parsed.ptr == port_text.data() + port_text.size();
  const int lowest = use == EndpointUse::listen ? 0 : 1;
  const bool host_good =
      !host.empty() && host.size() <= 253 && host.find_first_of("/;@") == std::string_view::npos &&
      std::none_of(host.begin(), host.end(), [](char c) { return c <= ' ' || c == 127; }) &&
      (use == EndpointUse::listen || host != "*");
  if (!host_good || !number || port < lowest || port > 65535) {
    return wrong_use("{}: the form tcp://HOST:PORT with a port from {} to 65535 is expected", shown(text),
                     lowest);
  }
  // ZeroMQ binds to interfaces and numbers, not to names.
  const std::string_view known = use == EndpointUse::listen && host == "localhost" ? "127.0.0.1" : host;
  return Endpoint{fmt::format("tcp://{}:{}", known, port), {}, !insecure};
}

std::filesystem::path lock_path(const std::filesystem::path& socket) { return socket.string() + ".lock"; }

// Held for a server at this socket, with its process number in it.
Expected<FileDescriptor> claim_lock(const std::filesystem::path& socket) {
  const auto path = lock_path(socket);
  auto lock = lock_file(path);
  if (!lock) return tl::unexpected(lock.error());
  if (!*lock) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
    char holder[32] = {};
    const ssize_t length = file ? ::pread(file.get(), holder, sizeof holder - 1, 0) : 0;
    return refused("ipc://{}: address in use by process {}; stop it or listen at another address",
                   socket.string(), length > 0 ? holder : "(unknown)");
  }
  const std::string pid = std::to_string(::getpid());
  // The number is for people only; the lock holds without it.
  static_cast<void>(::ftruncate((*lock)->get(), 0) == 0 &&
                    ::pwrite((*lock)->get(), pid.data(), pid.size(), 0) > 0);
  return std::move(**lock);
}

}  // namespace

bool somebody_listens(const std::filesystem::path& socket_path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_path.native().size() > kMaxSocketPath) return false;
  std::memcpy(address.sun_path, socket_path.c_str(), socket_path.native().size());
  const FileDescriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return false;
  const int connected = ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  return connected == 0 || errno == EAGAIN;  // EAGAIN: its queue is full
}

Expected<Endpoint> default_endpoint(std::string_view name) {
  const auto folder = run_directory();
  if (!folder) return tl::unexpected(folder.error());
  const std::filesystem::path socket = *folder / fmt::format("{}.sock", name);
  if (auto length = check_length(socket); !length) return tl::unexpected(length.error());
  return Endpoint{"ipc://" + socket.string(), socket, false};
}

Expected<Endpoint> parse_endpoint(std::string_view text, EndpointUse use, bool insecure) {
  if (text.starts_with("ipc://")) return parse_ipc(text.substr(6), insecure);
  if (text.starts_with("tcp://")) return parse_tcp(text, use, insecure);
  return wrong_use("{}: not an address; expected ipc://PATH or tcp://HOST:PORT", shown(text));
}

Expected<Endpoint> states_endpoint(const Endpoint& service) {
  if (service.local()) {
    const std::filesystem::path socket = service.socket.string() + ".states";
    if (auto length = check_length(socket); !length) return tl::unexpected(length.error());
    return Endpoint{"ipc://" + socket.string(), socket, false};
  }
  const std::size_t colon = service.address.rfind(':');
  const int port = std::atoi(service.address.c_str() + colon + 1);
  if (port == 65535)
    return wrong_use("{}: states are published one port above, which there is none; choose a lower port",
                     service.address);
  return Endpoint{fmt::format("{}:{}", service.address.substr(0, colon), port == 0 ? 0 : port + 1),
                  {},
                  service.encrypted};
}

Expected<SocketClaim> SocketClaim::take(const std::filesystem::path& socket) {
  auto lock = claim_lock(socket);
  if (!lock) return tl::unexpected(lock.error());
  SocketClaim claim(std::move(*lock), socket);
  struct stat info {};
  if (!exists(socket, info)) {
    claim.ours_ = true;
    return claim;
  }
  if (!S_ISSOCK(info.st_mode)) {
    return refused("{}: exists and is not a socket; remove it or listen at another address", socket.string());
  }
  if (somebody_listens(socket)) {
    return refused("ipc://{}: address in use by another program; stop it or listen at another address",
                   socket.string());
  }
  if (::unlink(socket.c_str()) != 0) {
    return refused("{}: a dead server's socket cannot be removed: {}", socket.string(), reason());
  }
  claim.ours_ = true;
  return claim;
}

SocketClaim::SocketClaim(SocketClaim&& other) noexcept
    : lock_(std::move(other.lock_)), socket_(std::move(other.socket_)), ours_(other.ours_) {}

SocketClaim& SocketClaim::operator=(SocketClaim&& other) noexcept {
  if (this != &other) {
    release();
    lock_ = std::move(other.lock_);
    socket_ = std::move(other.socket_);
    ours_ = other.ours_;
  }
  return *this;
}

SocketClaim::~SocketClaim() { release(); }

void SocketClaim::release() {
  if (!lock_) return;
  if (ours_) ::unlink(socket_.c_str());
  ::unlink(lock_path(socket_).c_str());
  lock_.close();
}

}  // namespace palpate::transport
