#include "drivers/arms/maker_library.h"

#include <dlfcn.h>
#include <elf.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "palpate/core/text.h"

namespace palpate::drivers::arms {
namespace {

namespace fs = std::filesystem;

#if defined(__x86_64__)
constexpr std::uint16_t kOwnMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr std::uint16_t kOwnMachine = EM_AARCH64;
#else
constexpr std::uint16_t kOwnMachine = EM_NONE;  // not told apart: the loader's words have to do
#endif

std::string machine_name(std::uint16_t machine) {
  switch (machine) {
    case EM_X86_64:
      return "x86_64";
    case EM_AARCH64:
      return "aarch64";
    case EM_386:
      return "i386";
    case EM_ARM:
      return "arm";
    default:
      return fmt::format("machine {}", machine);
  }
}

// Of the first bytes of a file; `none` where nothing speaks against loading it.
LibraryProblem judge_head(std::string_view head, std::string& detail) {
  constexpr std::string_view kArchive = "!<arch>\n";
  if (head.starts_with(kArchive)) return LibraryProblem::static_library;
  constexpr std::size_t kHead = 20;
  if (head.size() < kHead || !head.starts_with(std::string_view(ELFMAG, SELFMAG)))
    return LibraryProblem::not_a_library;
  if (head[EI_CLASS] == ELFCLASS32 && sizeof(void*) == 8) return LibraryProblem::thirty_two_bit;
  const auto byte = [&](std::size_t at) {
    return static_cast<unsigned>(static_cast<unsigned char>(head[at]));
  };
  const auto machine = static_cast<std::uint16_t>(byte(18) | byte(19) << 8);
  if (kOwnMachine == EM_NONE || machine == kOwnMachine) return LibraryProblem::none;
  detail = machine_name(machine);
  return LibraryProblem::other_machine;
}

void look_at_head(LibraryFacts& facts) {
  std::error_code ignored;
  if (!fs::exists(facts.file, ignored)) return;
  facts.problem = LibraryProblem::unreadable;
  if (!fs::is_regular_file(facts.file, ignored)) return;  // opening alone may wait for a pipe's other end
  std::ifstream in(facts.file, std::ios::binary);
  if (!in.is_open()) return;
  std::array<char, 20> head{};
  in.read(head.data(), head.size());
  facts.problem = judge_head({head.data(), static_cast<std::size_t>(in.gcount())}, facts.detail);
}

// The loader tells of a library that is missing as "NAME: cannot open shared object file: ...".
std::string missing_library(const std::string& words, const std::string& file) {
  const auto end = words.find(": cannot open shared object file");
  if (end == std::string::npos) return "";
  const std::string name = words.substr(0, end);
  return name == file ? "" : name;
}

void judge_loader(LibraryFacts& facts, const fs::path& file, const std::string& words) {
  facts.detail = missing_library(words, facts.file);
  if (!facts.detail.empty()) {
    facts.problem = LibraryProblem::missing_dependency;
  } else if (!file.has_parent_path() && words.find("cannot open shared object") != std::string::npos) {
    facts.problem = LibraryProblem::not_found;
    facts.file.clear();
  } else {
    facts.problem = LibraryProblem::not_loadable;
    facts.detail = excerpt(words, 200);
  }
}

// One file, or a name for the loader to find.
LibraryFacts open_file(const MakerLibrary& library, const fs::path& file, const LibraryReader& reader) {
  LibraryFacts facts{.library = &library, .file = file.string()};
  if (file.has_parent_path()) {
    look_at_head(facts);
    if (facts.problem != LibraryProblem::none) return facts;
  }
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    const char* said = dlerror();
    judge_loader(facts, file, said == nullptr ? "no reason given" : said);
    return facts;
  }
  LibraryFunctions functions(handle);
  reader.take(functions);
  facts.detail = functions.missing();
  facts.problem = facts.detail.empty() ? LibraryProblem::none : LibraryProblem::missing_function;
  if (facts.problem == LibraryProblem::none) facts.version = reader.version();
  return facts;
}

}  // namespace

void* LibraryFunctions::find(const char* name) const { return dlsym(handle_, name); }

LibraryFacts find_library(const MakerLibrary& library, const fs::path& file, const LibraryReader& reader) {
  if (!file.empty()) return open_file(library, fs::absolute(file), reader);
  if (const char* named = std::getenv(library.variable.c_str()); named != nullptr && *named != '\0')
    return open_file(library, fs::absolute(named), reader);
  LibraryFacts first{.library = &library};
  for (const auto& place : library.places) {
    LibraryFacts facts = open_file(library, place, reader);
    if (facts.problem == LibraryProblem::none) return facts;
    if (first.problem == LibraryProblem::not_found) first = std::move(facts);
  }
  if (first.problem == LibraryProblem::not_found) first.file.clear();
  return first;
}

std::string LibraryFacts::reason() const {
  switch (problem) {
    case LibraryProblem::none:
      return "";
    case LibraryProblem::not_found:
      return file.empty() ? fmt::format("{} of {} is not on this machine", library->file, library->product)
                          : file + " is not there";
    case LibraryProblem::unreadable:
      return file + " cannot be read";
    case LibraryProblem::not_a_library:
      return file + " is no shared library";
    case LibraryProblem::static_library:
      return file + " is a static library, which cannot be loaded at run time";
    case LibraryProblem::thirty_two_bit:
      return file + " is a 32-bit library, this program has 64 bits";
    case LibraryProblem::other_machine:
      return fmt::format("{} is built for {}, this program for {}", file, detail, machine_name(kOwnMachine));
    case LibraryProblem::missing_dependency:
      return fmt::format("{} needs {}, which is not on this machine", file, detail);
    case LibraryProblem::missing_function:
      return fmt::format("{} lacks {}", file, detail);
    case LibraryProblem::not_loadable:
      return fmt::format("{} cannot be loaded: {}", file, detail);
  }
  return "";
}

std::string LibraryFacts::remedy() const {
  switch (problem) {
    case LibraryProblem::none:
      return "";
    case LibraryProblem::not_found:
      return fmt::format("{}, or name the file: {}=/path/{}", library->install, library->variable,
                         library->file);
    case LibraryProblem::unreadable:
      return "give yourself the right to read it, or name another with " + library->variable;
    case LibraryProblem::not_a_library:
    case LibraryProblem::static_library:
      return fmt::format("name the {} of {} with {}", library->file, library->product, library->variable);
    case LibraryProblem::thirty_two_bit:
    case LibraryProblem::other_machine:
      return fmt::format("install {} for this machine's processor, or name another file with {}",
                         library->product, library->variable);
    case LibraryProblem::missing_dependency:
      for (const auto& [part, remedy] : library->dependencies)
        if (detail.find(part) != std::string::npos) return remedy;
      return "install the package that has it (apt-file search " + detail + "), then ldconfig";
    case LibraryProblem::missing_function:
      return fmt::format("install {} or newer, or name its {} with {}", library->oldest, library->file,
                         library->variable);
    case LibraryProblem::not_loadable:
      return fmt::format("install {} anew, or name another {} with {}", library->product, library->file,
                         library->variable);
  }
  return "";
}

Error LibraryFacts::refusal() const {
  return {Error::Kind::refused, fmt::format("{}: {}; {}", library->driver, reason(), remedy())};
}

}  // namespace palpate::drivers::arms
