// palpate report: the page of a folder again, after its templates or limits have been changed.
#include <memory>

#include "palpate/core/file.h"
#include "palpate/evaluation/report/page.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/demo/demo_report.h"

namespace palpate::tools::commands {
namespace {

struct ReportCommand {
  std::filesystem::path folder;
  std::string templates;
};

Expected<void> say_where(const std::filesystem::path& folder) {
  print_line(fmt::format("written to {}", (folder / "report.html").string()), stdout);
  return {};
}

// A demo's folder has its summary, from which figures are judged anew; a study's has its report.
Expected<void> write_again(const ReportCommand& options) {
  evaluation::report::PageTemplates templates;
  if (!options.templates.empty())
    if (auto read = templates.add_folder(options.templates); !read) return read;
  if (is_there(options.folder / "summary.json")) {
    const auto report = demo::write_demo_report(options.folder, known_applications(), std::move(templates));
    if (!report) return tl::unexpected(report.error());
    return say_where(options.folder);
  }
  if (!is_there(options.folder))
    return wrong_use("report: {}: no such folder; that of a demo or study is expected",
                     options.folder.string());
  const auto written = read_file(options.folder / "report.json");
  if (!written)
    return wrong_use(
        "report: {} holds neither summary.json nor report.json; a folder of demo or study is expected",
        options.folder.string());
  if (auto done =
          evaluation::report::write_report(Json::parse(*written, nullptr, false), templates, options.folder);
      !done)
    return done;
  return say_where(options.folder);
}

}  // namespace

void add_report(CLI::App& program) {
  auto* command = program.add_subcommand(
      "report", "Write a folder's report.json and report.html again, with templates and limits of one's own");
  auto options = std::make_shared<ReportCommand>();
  command->add_option("folder", options->folder, "Folder that palpate demo or palpate study wrote")
      ->required();
  command->add_option("--templates", options->templates,
                      "Folder of files that replace those of share/palpate/report of the same name");
  on(command, [options] { return write_again(*options); });
}

}  // namespace palpate::tools::commands
