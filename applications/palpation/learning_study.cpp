#include "applications/palpation/learning_study.h"

#include <filesystem>

#include "applications/palpation/learning_curve.h"
#include "palpate/core/text.h"

namespace palpate::applications::palpation {
namespace {

scene::SettingSchema learning_schema() {
  return {.fields = {{.section = "study",
                      .key = "file",
                      .kind = scene::SettingKind::file,
                      .initial = "",
                      .help = "Of finished searches, as --learning FILE has kept it"}}};
}

Expected<scene::StudyOutcome> run_learning_study(const scene::StudyRequest& request) {
  const std::string& file = request.settings.text("study.file");
  if (file.empty())
    return wrong_use(
        "--file: is missing; name the file that `palpate ... --app palpation --learning FILE` "
        "has kept");
  const auto lines = read_learning(file);
  if (!lines) return tl::unexpected(lines.error());
  if (lines->empty())
    return refused("{}: holds no search yet; one is kept when it is over", excerpt(file, 200));
  return learning_outcome(*lines, excerpt(std::filesystem::path(file).filename().string(), 80));
}

}  // namespace

scene::ApplicationStudy learning_study() {
  return {.name = "learning",
          .summary = "What a person has learned in palpation: nodules found, time and level over sessions",
          .settings = learning_schema(),
          .run = run_learning_study};
}

}  // namespace palpate::applications::palpation
