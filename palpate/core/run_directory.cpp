#include "palpate/core/run_directory.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "palpate/core/system_error.h"

namespace palpate::inline core {

Expected<std::filesystem::path> private_directory(const std::filesystem::path& folder) {
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
    return refused("{}: cannot make this private folder: {}", folder.string(), reason_of(errno));
  if (auto own = check_private_directory(folder); !own) return tl::unexpected(own.error());
  return folder;
}

Expected<void> check_private_directory(const std::filesystem::path& folder) {
  struct stat info {};
  if (lstat(folder.c_str(), &info) != 0)
    return refused("{}: cannot look at this folder: {}", folder.string(), reason_of(errno));
  if (!S_ISDIR(info.st_mode))
    return refused("{}: expected a folder of our own, found something else; remove it", folder.string());
  if (info.st_uid != geteuid())
    return refused("{}: belongs to user {}, expected user {}; set XDG_RUNTIME_DIR to a folder of your own",
                   folder.string(), info.st_uid, geteuid());
  if ((info.st_mode & 0077) != 0)
    return refused("{}: open to other users (mode {:o}), expected 700; chmod 700 it", folder.string(),
                   info.st_mode & 0777u);
  return {};
}

std::filesystem::path run_directory_place() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code ignored;
  // Within `su` and containers the variable often names a folder that is not there.
  if (runtime != nullptr && *runtime == '/' && std::filesystem::is_directory(runtime, ignored))
    return std::filesystem::path(runtime) / "palpate";
  return fmt::format("/dev/shm/palpate-{}", geteuid());
}

Expected<std::filesystem::path> run_directory() { return private_directory(run_directory_place()); }

}  // namespace palpate::inline core
