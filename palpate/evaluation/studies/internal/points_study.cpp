// The paper's Figures 7, 8 and 9: what the arm's calibration reaches with how many points.
#include "palpate/evaluation/studies/internal/points_study.h"

namespace palpate::evaluation::studies {
namespace {

struct Part {
  Expected<void> (*add)(StudyResult&, const StudyOptions&);
  double share;  // of the time, for the progress bar
};
constexpr std::array<Part, 4> kParts{
    {{add_splits, 0.6}, {add_bound, 0.25}, {add_outliers, 0.1}, {add_one_arm, 0.05}}};

}  // namespace

Expected<StudyResult> study_points(const StudyOptions& options) {
  StudyResult study;
  study.name = "points";
  double before = 0.0;
  for (const auto& part : kParts) {
    StudyOptions own = options;
    if (options.repeats.progress)
      own.repeats.progress = [&, before](double share) {
        options.repeats.progress(before + share * part.share);
      };
    if (const auto added = part.add(study, own); !added) return tl::unexpected(added.error());
    before += part.share;
  }
  auto page = points_page(study);
  if (!page) return tl::unexpected(page.error());
  study.page = std::move(*page);
  return study;
}

}  // namespace palpate::evaluation::studies
