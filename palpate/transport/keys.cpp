#include "palpate/transport/keys.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <system_error>
#include <thread>
#include <utility>

#include "palpate/core/file.h"
#include "palpate/core/file_descriptor.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/system_error.h"
#include "palpate/core/text.h"

namespace palpate::transport {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kKeyCharacters = 40;
constexpr std::size_t kMostKeyFileBytes = 1 << 20;
constexpr std::array<std::pair<Role, std::string_view>, 3> kRoles{
    {{Role::observer, "observer"}, {Role::graphics, "graphics"}, {Role::operator_, "operator"}}};

// The words of a line, at most `most`; the last one takes the rest.
std::vector<std::string> words_of(std::string_view line, std::size_t most) {
  std::vector<std::string> words;
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!line.empty() && blank(line.back())) line.remove_suffix(1);
  while (true) {
    while (!line.empty() && blank(line.front())) line.remove_prefix(1);
    if (line.empty()) return words;
    std::size_t end = 0;
    while (end < line.size() && !blank(line[end])) ++end;
    if (words.size() + 1 == most) end = line.size();
    words.emplace_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

bool comment(const std::vector<std::string>& words) { return words.empty() || words[0][0] == '#'; }

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const auto end = text.find('\n');
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

std::string text_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + '\n';
  return text;
}

// Bytes of a file that another thread reads, too.
struct Reading {
  int error = 0;
  std::string text;
};

Reading read_whole(const fs::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) return {errno, {}};
  Reading reading;
  std::array<char, 4096> part{};
  while (reading.text.size() <= kMostKeyFileBytes) {
    const ssize_t got = ::read(file.get(), part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) reading.error = errno;
    if (got <= 0) break;
    reading.text.append(part.data(), static_cast<std::size_t>(got));
  }
  return reading;
}

// The same where this process has no descriptor left, which its peers may have brought about: in a thread
// with a table of descriptors of its own.
Reading read_whole_apart(const fs::path& path) {
  Reading reading{EMFILE, {}};
  try {
    const std::function<void()> read = [&] {
      if (::close_range(3, ~0U, CLOSE_RANGE_UNSHARE) == 0) reading = read_whole(path);
    };
    std::thread(read).join();
  } catch (const std::system_error&) {  // no thread left either
  }
  return reading;
}

// Who can write to the folder can put another file in the place of one that is fine in itself.
Expected<void> check_keys_folder(const fs::path& folder, const struct stat& info) {
  if (info.st_uid != geteuid())
    return refused("{}: this folder belongs to user {}, not to {}; keys must lie in a folder of your own",
                   folder.string(), info.st_uid, geteuid());
  if ((info.st_mode & 0022u) != 0)
    return refused("{}: others can write to this folder of keys (mode {:o}); chmod 700 it", folder.string(),
                   info.st_mode & 0777u);
  return {};
}

// The file's text, empty where there is none. Refused where users other than ours could have written it or
// put it there, and with `secret` where they could read it; ErrorCode::exhausted as in read_authorized_keys().
Expected<std::string> read_own_file(const fs::path& path, bool secret) {
  struct stat info {};
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (stat(folder.c_str(), &info) == 0)
    if (auto own = check_keys_folder(folder, info); !own) return tl::unexpected(own.error());
  if (stat(path.c_str(), &info) != 0) {
    if (errno == ENOENT) return std::string();
    return refused(code_of(errno), "{}: cannot be looked at ({})", path.string(), reason_of(errno));
  }
  if (info.st_uid != geteuid())
    return refused("{}: belongs to user {}, not to {}; keys must be your own", path.string(), info.st_uid,
                   geteuid());
  const mode_t open = info.st_mode & (secret ? 0077u : 0022u);
  if (open != 0)
    return refused("{}: others can {} it (mode {:o}); chmod {} it", path.string(), secret ? "read" : "write",
                   info.st_mode & 0777u, secret ? "600" : "644");
  if (S_ISDIR(info.st_mode)) return wrong_use("{}: is a folder, a file is expected", path.string());
  if (!S_ISREG(info.st_mode)) return wrong_use("{}: is no plain file, as one is expected", path.string());
  if (static_cast<std::uint64_t>(info.st_size) > kMostKeyFileBytes)
    return refused("{}: {} bytes are no list of keys", path.string(), info.st_size);
  Reading reading = read_whole(path);
  if (reading.error == EMFILE) reading = read_whole_apart(path);
  if (reading.error == 0) return std::move(reading.text);
  return wrong_use(code_of(reading.error), "{}: cannot be read ({}); check its permissions", path.string(),
                   reason_of(reading.error));
}

Expected<void> make_keys_folder(const fs::path& folder) {
  if (folder.has_parent_path())
    if (auto parents = make_folder(folder.parent_path()); !parents) return parents;
  if (auto own = private_directory(folder); !own) return tl::unexpected(own.error());
  return {};
}

// Held while a file of the folder is read, changed and put back, so that commands at once do not undo each
// other. The lock's file stays: who removed it would take it from somebody who waits for it.
class FolderLock {
 public:
  static constexpr std::chrono::seconds kPatience{5};

  static Expected<FolderLock> take(const fs::path& folder) {
    const fs::path file = folder / "lock";
    FolderLock lock(FileDescriptor(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600)));
    if (!lock.fd_)
      return refused(
          "{}: cannot be opened ({}), and without it keys are not changed; check it and its folder",
          file.string(), reason_of(errno));
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (::flock(lock.fd_.get(), LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK && errno != EINTR)
        return refused("{}: cannot be locked ({}), and without that keys are not changed", file.string(),
                       reason_of(errno));
      if (std::chrono::steady_clock::now() >= until)
        return refused("{}: another program has held it for {} s; nothing was changed, try again",
                       file.string(), kPatience.count());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return lock;
  }

 private:
  explicit FolderLock(FileDescriptor fd) : fd_(std::move(fd)) {}
  FileDescriptor fd_;
};

// The lines of a file in the folder become those that `change` makes of them.
using Lines = std::vector<std::string>;
Expected<void> change_lines(const fs::path& file, const std::function<Expected<Lines>(Lines)>& change) {
  const auto lock = FolderLock::take(file.parent_path());
  if (!lock) return tl::unexpected(lock.error());
  const auto text = read_own_file(file, false);
  if (!text) return tl::unexpected(text.error());
  const auto lines = change(lines_of(*text));
  if (!lines) return tl::unexpected(lines.error());
  return write_file(file, text_of(*lines));
}

fs::path authorized_file(const fs::path& folder) { return folder / "authorized_keys"; }
fs::path servers_file(const fs::path& folder) { return folder / "known_servers"; }
fs::path secret_file(const fs::path& folder) { return folder / "secret_key"; }

Expected<void> check_key(const std::string& key) {
  if (is_key(key)) return {};
  return wrong_use("'{}' is no public key; 40 characters, as `palpate keys show` prints them, are expected",
                   excerpt(key, 60));
}

}  // namespace

std::string_view role_name(Role role) { return kRoles[static_cast<std::size_t>(role)].second; }

std::optional<Role> role_named(std::string_view name) {
  for (const auto& [role, known] : kRoles)
    if (name == known) return role;
  return std::nullopt;
}

bool may(Role role, scene::Control control) {
  return control == scene::Control::begin ? role >= Role::graphics : role >= Role::operator_;
}

bool is_key(std::string_view text) {
  std::array<std::uint8_t, 32> bytes{};
  return text.size() == kKeyCharacters && zmq_z85_decode(bytes.data(), std::string(text).c_str()) != nullptr;
}

Expected<fs::path> keys_folder() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config != nullptr && *config == '/') return fs::path(config) / "palpate";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home == '/') return fs::path(home) / ".config" / "palpate";
  return refused("no place for keys: neither XDG_CONFIG_HOME nor HOME names a folder; give --keys DIR");
}

Expected<KeyPair> make_key_pair() {
  std::array<char, kKeyCharacters + 1> own{}, secret{};
  do {
    if (zmq_curve_keypair(own.data(), secret.data()) != 0)
      return refused("keys: this machine's ZeroMQ knows no encryption ({}); install libzmq with CURVE",
                     reason_of(errno));
  } while (own[0] == '-');  // on a command line it would look like an option
  return KeyPair{own.data(), secret.data()};
}

Expected<KeyPair> read_key_pair(const fs::path& folder) {
  const fs::path file = secret_file(folder);
  const auto text = read_own_file(file, true);
  if (!text) return tl::unexpected(text.error());
  if (text->empty())
    return refused("{}: this machine has no keys yet; make them with `palpate keys new`", file.string());
  KeyPair pair;
  for (const auto& line : lines_of(*text)) {
    const auto words = words_of(line, 2);
    if (comment(words)) continue;
    if (words.size() == 2 && words[0] == "public" && is_key(words[1])) pair.public_key = words[1];
    if (words.size() == 2 && words[0] == "secret" && is_key(words[1])) pair.secret_key = words[1];
  }
  std::array<char, kKeyCharacters + 1> derived{};
  if (pair.secret_key.empty() || zmq_curve_public(derived.data(), pair.secret_key.c_str()) != 0 ||
      pair.public_key != derived.data())
    return refused(
        "{}: holds no pair of keys that belong together; make new ones with `palpate keys new --force`",
        file.string());
  return pair;
}

Expected<void> write_key_pair(const fs::path& folder, const KeyPair& pair, bool replace) {
  if (auto made = make_keys_folder(folder); !made) return made;
  const auto lock = FolderLock::take(folder);
  if (!lock) return tl::unexpected(lock.error());
  const fs::path file = secret_file(folder);
  std::error_code ignored;
  if (!replace && fs::exists(file, ignored))
    return refused(
        "{}: there is a pair of keys already; --force replaces it, and others must then admit the new one",
        file.string());
  return write_file(
      file,
      fmt::format("# Keys of this machine for palpate's encrypted connections. Whoever has the\n"
                  "# secret can pass for this machine; the public one is for the others.\n"
                  "public {}\nsecret {}\n",
                  pair.public_key, pair.secret_key),
      FileMode::own);
}

std::optional<Role> AuthorizedKeys::role_of(std::string_view key) const {
  for (const auto& known : keys)
    if (known.key == key) return known.role;
  return std::nullopt;
}

AuthorizedKeys parse_authorized_keys(std::string_view text, const std::string& source) {
  AuthorizedKeys result;
  int number = 0;
  for (const auto& line : lines_of(text)) {
    ++number;
    const auto words = words_of(line, 3);
    if (comment(words)) continue;
    const auto complain = [&](const std::string& what) {
      result.complaints.push_back(fmt::format("{}:{}: {}", source, number, what));
    };
    const auto role = role_named(words[0]);
    if (!role) {
      complain(fmt::format("'{}' is no role; observer, graphics or operator is expected", excerpt(words[0])));
    } else if (words.size() < 2 || !is_key(words[1])) {
      complain("a public key of 40 characters is expected after the role");
    } else if (result.role_of(words[1])) {
      complain("this key stands above already and that line counts; remove one");
    } else {
      result.keys.push_back({*role, words[1], words.size() > 2 ? words[2] : std::string()});
    }
  }
  return result;
}

Expected<AuthorizedKeys> read_authorized_keys(const fs::path& folder) {
  const fs::path file = authorized_file(folder);
  const auto text = read_own_file(file, false);
  if (!text) return tl::unexpected(text.error());
  return parse_authorized_keys(*text, file.string());
}

Expected<void> authorize_key(const fs::path& folder, const AuthorizedKey& key) {
  if (auto good = check_key(key.key); !good) return good;
  if (excerpt(key.name, 100) != key.name)
    return wrong_use("--name '{}': one line of at most 100 bytes is expected", excerpt(key.name, 100));
  if (auto made = make_keys_folder(folder); !made) return made;
  return change_lines(authorized_file(folder), [&key](Lines before) -> Expected<Lines> {
    if (before.empty())
      before = {"# Who is admitted to the physics server of this machine: ROLE PUBLIC-KEY NAME, a line each.",
                "# Roles: observer (sees), graphics (sees and serves), operator (also resets and pauses)."};
    Lines lines;
    for (auto& line : before) {
      const auto words = words_of(line, 3);
      if (comment(words) || words.size() < 2 || words[1] != key.key) lines.push_back(std::move(line));
    }
    lines.push_back(
        fmt::format("{} {}{}{}", role_name(key.role), key.key, key.name.empty() ? "" : " ", key.name));
    return lines;
  });
}

Expected<std::size_t> revoke_keys(const fs::path& folder, std::string_view key_or_name) {
  const fs::path file = authorized_file(folder);
  const auto unknown = refused("{}: holds no key and no name '{}'; `palpate keys show` lists them",
                               file.string(), excerpt(key_or_name, 60));
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return unknown;  // and perhaps no folder to lock
  std::size_t removed = 0;
  const auto changed = change_lines(file, [&](Lines before) -> Expected<Lines> {
    Lines lines;
    for (auto& line : before) {
      const auto words = words_of(line, 3);
      const bool meant = !comment(words) && words.size() >= 2 &&
                         (words[1] == key_or_name || (words.size() > 2 && words[2] == key_or_name));
      if (meant) ++removed;
      if (!meant) lines.push_back(std::move(line));
    }
    if (removed == 0) return unknown;
    return lines;
  });
  if (!changed) return tl::unexpected(changed.error());
  return removed;
}

Expected<std::map<std::string, std::string>> read_known_servers(const fs::path& folder) {
  const auto text = read_own_file(servers_file(folder), false);
  if (!text) return tl::unexpected(text.error());
  std::map<std::string, std::string> servers;
  int number = 0;
  for (const auto& line : lines_of(*text)) {
    ++number;
    const auto words = words_of(line, 3);
    if (comment(words)) continue;
    if (words.size() != 2 || !is_key(words[1]))
      return refused("{}:{}: an address and a public key of 40 characters are expected",
                     servers_file(folder).string(), number);
    servers[words[0]] = words[1];
  }
  return servers;
}

Expected<void> trust_server(const fs::path& folder, const std::string& address, const std::string& key) {
  if (auto good = check_key(key); !good) return good;
  if (auto made = make_keys_folder(folder); !made) return made;
  return change_lines(servers_file(folder), [&](Lines before) -> Expected<Lines> {
    Lines lines;
    for (auto& line : before) {
      const auto words = words_of(line, 2);
      if (comment(words) || words[0] != address) lines.push_back(std::move(line));
    }
    lines.push_back(address + ' ' + key);
    return lines;
  });
}

Expected<ServerIdentity> server_identity(const fs::path& folder) {
  auto own = read_key_pair(folder);
  if (!own) return tl::unexpected(own.error());
  if (const auto readable = read_authorized_keys(folder); !readable) return tl::unexpected(readable.error());
  return ServerIdentity{std::move(*own), folder};
}

Expected<ClientIdentity> client_identity(const fs::path& folder, const std::string& address,
                                         const std::string& server_key) {
  auto own = read_key_pair(folder);
  if (!own) return tl::unexpected(own.error());
  if (!server_key.empty()) {
    if (auto good = check_key(server_key); !good) return tl::unexpected(good.error());
    return ClientIdentity{std::move(*own), server_key};
  }
  const auto servers = read_known_servers(folder);
  if (!servers) return tl::unexpected(servers.error());
  const auto known = servers->find(address);
  if (known == servers->end())
    return refused(
        "{}: the key of this server is not known; ask for it there (`palpate keys show`) and enter it with "
        "`palpate keys trust {} KEY`",
        address, address);
  return ClientIdentity{std::move(*own), known->second};
}

}  // namespace palpate::transport
