// What a program was made of and by what, for those who read its results later.
#pragma once

#include <string>

namespace palpate::inline core {

struct BuildInfo {
  std::string version;   // "0.1.0"
  std::string commit;    // "3d8d93f1"; "3d8d93f1-dirty" where files differed from it; empty: not known
  std::string compiler;  // "Clang 14.0.6"
  std::string options;   // "Release, -O2 -DNDEBUG"
};

// "0.1.0 (3d8d93f1, Clang 14.0.6, Release, -O2 -DNDEBUG)".
inline std::string text_of(const BuildInfo& build) {
  const std::string commit = build.commit.empty() ? "commit not known" : build.commit;
  std::string text = build.version + " (" + commit;
  for (const auto& part : {build.compiler, build.options})
    if (!part.empty()) text += ", " + part;
  return text + ')';
}

}  // namespace palpate::inline core
