// Loads plug-ins (plugin.h) into a program, and refuses in words what cannot be one, or might be somebody else's.
//
// A plug-in is code with all rights of who runs the program. So it is taken only where nobody but this user and root
// can have put it: the file and every folder above it belong to one of the two and are not writable for group or
// others (a folder with the sticky bit, as /tmp, may be). A program with rights of its own (set-user-id, file
// capabilities) takes them from the system's folder alone.
//
// Loaded at once and for good, with all symbols resolved; its names are seen by nobody else (RTLD_NOW, RTLD_LOCAL).
// Main thread, before there are others. What a plug-in's static constructors do cannot be held: they run before it is
// asked who it is.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/plugin/guests.h"

namespace palpate::plugin {

// Where something that was added came from.
struct Loaded {
  std::filesystem::path file;  // canonical
  std::string name;            // as the plug-in calls itself
  std::vector<std::string> applications, drivers;
};

struct Report {
  std::vector<Loaded> loaded;
  std::vector<std::string> skipped;  // why, a line for each file or folder that was found and not taken

  // Null: not from a plug-in.
  const Loaded* origin_of_application(std::string_view name) const;
  const Loaded* origin_of_driver(std::string_view scheme) const;
};

// Wrong use: no such file. Refused: any other reason why it is none of ours; `guests` are then as they were. A file
// that is loaded already is passed over.
Expected<void> load(const std::filesystem::path& file, Guests& guests, Report& report);

// Every *.so of a folder, in the order of their names; what is refused is told in the report. A folder that is not
// there is none.
void load_folder(const std::filesystem::path& folder, Guests& guests, Report& report);

// Where plug-ins are looked for beside those named: PALPATE_PLUGIN_PATH (folders and files, ':' between them), the
// user's ~/.local/lib/palpate/plugins, and `system`.
struct SearchPath {
  std::vector<std::filesystem::path> named;    // by PALPATE_PLUGIN_PATH: to be there
  std::vector<std::filesystem::path> folders;  // may be there
};
SearchPath search_path(const std::filesystem::path& system);
void load_all(const SearchPath& path, Guests& guests, Report& report);

// Whether this program was started with rights that who started it does not have.
bool has_rights_of_its_own();

// Refused, in words: somebody else than this user and root may change the file. `file` is canonical.
Expected<void> check_only_owner_writes(const std::filesystem::path& file);

}  // namespace palpate::plugin
