// The forms that are known, each with how it is recognised by its content and how it is read. internal/*.cpp.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/formats/content.h"
#include "palpate/formats/read.h"

namespace palpate::formats {

struct Source {
  std::string_view content;  // without a byte-order mark
  std::string name;
  const ReadOptions& options;
};

// The largest file of a few numbers (a lens, a transform, markups) that is taken apart.
inline constexpr std::size_t kMostBytesOfAFew = 4'000'000;

bool is_itk_transform(std::string_view content);
Expected<Content> read_itk_transform(const Source& source);

bool is_markups(std::string_view content);  // .mrk.json
Expected<Content> read_markups(const Source& source);
bool is_fiducials(std::string_view content);  // .fcsv
Expected<Content> read_fiducials(const Source& source);

// OpenCV's FileStorage, ROS' camera_info, easy_handeye, and other YAML with the same keys.
bool is_yaml(std::string_view content);
Expected<Content> read_yaml(const Source& source);
bool is_xml(std::string_view content);
Expected<Content> read_xml(const Source& source);
bool is_lens_json(std::string_view content);  // ours
Expected<Content> read_lens_json(const Source& source);

bool is_numpy(std::string_view content);
Expected<Content> read_numpy(const Source& source);

bool is_sequence(std::string_view content);  // .igs.mha, .seq.mha
Expected<Content> read_sequence(const Source& source);
bool is_nrrd_sequence(std::string_view content);  // .seq.nrrd, .nhdr
Expected<Content> read_nrrd_sequence(const Source& source);

// Rows of numbers without a header: TUM, KITTI, 4x4.
bool is_rows_of_numbers(std::string_view content);
Expected<Content> read_rows_of_numbers(const Source& source);

bool is_motive(std::string_view content);  // OptiTrack's
Expected<Content> read_motive(const Source& source);

// Rows with a header: ROS, EuRoC, NDI, and tables of ours whatever separates their cells.
bool is_table(std::string_view content);
// The same table with commas between its cells and points in its numbers, each line where it was; nothing where it has them
// already, or where a word holds a comma.
std::optional<std::string> with_commas(std::string_view content);
bool has_own_columns(std::string_view content);  // those of this program's tables
bool is_own_table(std::string_view content);     // with commas, and the columns of this program's tables
Expected<Content> read_table(const Source& source);

}  // namespace palpate::formats
