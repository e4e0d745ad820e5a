// --recording FILE --from S --to S of the calibrations, in place of their tables: a table that is not named comes out of the
// recording, as a file in a folder that is gone with the program: the table that it holds, or one made of its raw streams.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "palpate/record/session/recorded_tables.h"
#include "tools/commands/command.h"
#include "tools/commands/source_names.h"

namespace palpate::tools::commands {

class TableSource {
 public:
  TableSource() = default;
  ~TableSource();
  TableSource(const TableSource&) = delete;
  TableSource& operator=(const TableSource&) = delete;

  // An option of the command that names a table's file, `path`; `name`: what the table is called in a recording, empty: it is
  // not wanted there. `needed`: the
  // command does nothing without it.
  void add(std::string option, std::string& path, std::function<std::string()> name, bool needed = true);
  void add(std::string option, std::string& path, const char* name, bool needed = true) {
    add(
        std::move(option), path, [name] { return std::string(name); }, needed);
  }
  // --recording and, unless the command has such options of its own, --from and --to.
  void add_options(CLI::App& command, bool with_times = true);

  bool named() const { return !recording_.empty(); }
  // Before the command reads its tables: those that are not named are there then. Wrong use where one is missing and there is no
  // recording; refused where the recording does not hold it.
  Expected<void> supply();

 private:
  struct Table {
    std::string option;
    std::string* path;
    std::function<std::string()> name;
    bool needed;
  };
  Expected<void> take(const Table& table);
  Expected<std::string> text_of(const std::string& name) const;

  std::string recording_;
  record::session::TimeSpan span_;
  std::vector<Table> tables_;
  std::filesystem::path folder_;
};

// Runs `action` when `command` is chosen, its tables supplied.
inline void on(CLI::App* command, std::shared_ptr<TableSource> tables, Action action) {
  on(command, [tables = std::move(tables), action = std::move(action)]() -> Expected<void> {
    if (auto there = tables->supply(); !there) return there;
    auto done = action();
    if (!done) done.error().message = with_sources_named(std::move(done.error().message));
    return done;
  });
}

}  // namespace palpate::tools::commands
