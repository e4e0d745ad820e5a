#include "palpate/core/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>

namespace palpate::inline core {

namespace fs = std::filesystem;

Expected<std::string> read_file(const fs::path& path) {
  std::error_code code;
  const auto status = fs::status(path, code);
  if (!fs::exists(status)) return wrong_use("{}: no such file; check the path", path.string());
  if (fs::is_directory(status)) return wrong_use("{}: is a folder, a file is expected", path.string());
  std::ifstream in(path, std::ios::binary);
  if (!in)
    return wrong_use("{}: cannot be opened ({}); check its permissions", path.string(), std::strerror(errno));
  std::ostringstream content;
  content << in.rdbuf();
  if (in.bad()) return refused("{}: reading failed ({})", path.string(), std::strerror(errno));
  return content.str();
}

Expected<void> write_file(const fs::path& path, std::string_view content, FileMode mode) {
  if (path == "-") {
    const auto written = std::fwrite(content.data(), 1, content.size(), stdout);
    if (written != content.size() || std::fflush(stdout) != 0)
      return refused("standard output: writing failed ({})", std::strerror(errno));
    return {};
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code code;
  if (!fs::is_directory(folder, code))
    return wrong_use("{}: the folder {} does not exist; create it first", path.string(), folder.string());
  // Devices and pipes (/dev/stdout, a named pipe) cannot be replaced by a rename: write into them directly.
  const auto status = fs::status(path, code);
  const bool in_place = fs::exists(status) && !fs::is_regular_file(status);
  if (fs::is_directory(status)) return wrong_use("{}: is a folder, a file name is expected", path.string());
  std::string name = in_place ? path.string() : (path.string() + ".part-XXXXXX");
  const int fd = in_place ? ::open(name.c_str(), O_WRONLY | O_CLOEXEC) : ::mkstemp(name.data());
  if (fd < 0)
    return wrong_use("{}: cannot be written ({}); check the folder's permissions", path.string(),
                     std::strerror(errno));
  const auto fail = [&](const char* what) -> Expected<void> {
    const int cause = errno;
    ::close(fd);
    if (!in_place) ::unlink(name.c_str());
    return refused("{}: {} failed ({}); nothing was changed, free some space and try again", path.string(),
                   what, std::strerror(cause));
  };
  std::size_t done = 0;
  while (done < content.size()) {
    const auto n = ::write(fd, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return fail("writing");
    done += static_cast<std::size_t>(n);
  }
  if (in_place) {
    ::close(fd);
    return {};
  }
  if (::fchmod(fd, static_cast<mode_t>(mode)) != 0) return fail("setting permissions");
  if (::fsync(fd) != 0) return fail("writing to disk");
  if (::close(fd) != 0 || ::rename(name.c_str(), path.c_str()) != 0) {
    const int cause = errno;
    ::unlink(name.c_str());
    return refused("{}: cannot be put in place ({}); nothing was changed", path.string(),
                   std::strerror(cause));
  }
  return {};
}

Expected<void> make_folder(const fs::path& path) {
  std::error_code code;
  fs::create_directories(path, code);
  if (code || !fs::is_directory(path))
    return wrong_use("{}: the folder cannot be created ({})", path.string(),
                     code ? code.message() : "a file is in the way");
  return {};
}

std::string content_hash(std::string_view content) {
  std::uint64_t hash = 1469598103934665603ull;
  for (char c : content) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return fmt::format("{:016x}", hash);
}

}  // namespace palpate::inline core
