#include "palpate/vision/board.h"

#include <glob.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/picture_size.h"
#include "palpate/core/text.h"
#include "palpate/vision/board_continuation.h"
#include "palpate/vision/internal/grey_picture.h"

namespace palpate::vision {
namespace {

// Well inside one square even of a small board, never above the usual one.
int fitted_half_window(const std::vector<cv::Point2f>& corners, const BoardShape& shape) {
  const auto at = [&](int row, int column) {
    return corners[static_cast<std::size_t>(row * shape.columns + column)];
  };
  double nearest = 1e9;
  for (int row = 0; row < shape.rows; ++row)
    for (int column = 0; column < shape.columns; ++column) {
      if (column > 0) nearest = std::min(nearest, cv::norm(at(row, column) - at(row, column - 1)));
      if (row > 0) nearest = std::min(nearest, cv::norm(at(row, column) - at(row - 1, column)));
    }
  return std::clamp(static_cast<int>(0.45 * nearest), 2, kUsualHalfWindow);
}

cv::Mat no_larger(const cv::Mat& grey, double most_pixels) {
  const double scale = std::sqrt(most_pixels / static_cast<double>(grey.total()));
  if (scale >= 1.0) return grey;
  cv::Mat small;
  cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

// Whether a look at the image made smaller finds squares of both colours. The search itself goes through all
// pairs of dark patches: a minute where an image of no megapixel is noise, as of a camera in the dark.
bool may_hold_board(const cv::Mat& grey, const cv::Size& size) {
  return cv::checkChessboard(no_larger(grey, 1e6), size) ||
         cv::checkChessboard(no_larger(grey, 0.25e6), size);
}

// Neighbouring pixels of a photograph resemble each other: on average they differ by 1 to 8 of 256 levels, by some 85
// where all is noise, and by 27 where that is smoothed over 1.5 px.
bool is_noise(const cv::Mat& grey) {
  constexpr double kNoise = 20.0;
  if (grey.cols < 2) return true;
  cv::Mat equalised, step;
  cv::equalizeHist(grey, equalised);
  cv::absdiff(equalised.colRange(1, equalised.cols), equalised.colRange(0, equalised.cols - 1), step);
  return cv::mean(step)[0] > kNoise;
}

// In the image made smaller, told in the image's own pixels.
std::vector<cv::Point2f> corners_in(const cv::Mat& grey, const cv::Size& size, double most_pixels) {
  const cv::Mat small = no_larger(grey, most_pixels);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(small, size, corners,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE))
    return {};
  if (small.size() == grey.size()) return corners;
  const cv::Point2f scale(static_cast<float>(grey.cols) / static_cast<float>(small.cols),
                          static_cast<float>(grey.rows) / static_cast<float>(small.rows));
  for (cv::Point2f& corner : corners)
    corner = {(corner.x + 0.5f) * scale.x - 0.5f, (corner.y + 0.5f) * scale.y - 0.5f};
  return corners;
}

// Before they are refined; none where the board is not there. The look misses boards in cluttered pictures of wide
// lenses, 14 of 118 photographs (docs/theory/camera.md). `patient`: such pictures are searched all the same, as noise
// is not, which takes a second or two.
std::vector<cv::Point2f> rough_corners(const cv::Mat& grey, const BoardShape& shape, bool patient) {
  constexpr double kSearchedFirst = 0.4e6, kSearched = 1280.0 * 960.0;
  const cv::Size size(shape.columns, shape.rows);
  std::vector<cv::Point2f> corners;
  if (may_hold_board(grey, size)) corners = corners_in(grey, size, static_cast<double>(grey.total()));
  if (!corners.empty() || !patient || is_noise(grey)) return corners;
  corners = corners_in(grey, size, kSearchedFirst);
  return corners.empty() ? corners_in(grey, size, kSearched) : corners;
}

std::vector<device::Pixel> refined(const cv::Mat& grey, std::vector<cv::Point2f> corners, int half_window) {
  cv::cornerSubPix(grey, corners, {half_window, half_window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::MAX_ITER, 30, 0.001});
  std::vector<device::Pixel> pixels;
  for (const auto& corner : corners) pixels.emplace_back(corner.x, corner.y);
  return pixels;
}

std::vector<Vector3> board_points(const BoardShape& shape) {
  std::vector<Vector3> points;
  for (int i = 0; i < shape.corners(); ++i) points.push_back(shape.corner(i));
  return points;
}

std::vector<std::string> matching_files(const std::string& pattern) {
  glob_t found{};
  std::vector<std::string> files;
  if (::glob(pattern.c_str(), GLOB_TILDE, nullptr, &found) == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i) files.emplace_back(found.gl_pathv[i]);
  ::globfree(&found);
  return files;
}

}  // namespace

Expected<BoardShape> board_shape(const std::string& text, double square) {
  BoardShape shape;
  const auto* end = text.data() + text.size();
  const auto columns = std::from_chars(text.data(), end, shape.columns);
  const bool cross =
      columns.ec == std::errc() && columns.ptr != end && (*columns.ptr == 'x' || *columns.ptr == 'X');
  const auto rows = cross ? std::from_chars(columns.ptr + 1, end, shape.rows) : columns;
  if (!cross || rows.ec != std::errc() || rows.ptr != end || shape.columns < 2 || shape.rows < 2 ||
      shape.columns > 200 || shape.rows > 200)
    return wrong_use("--board '{}': inner corners as COLUMNSxROWS, 2 to 200 each, are expected, such as 9x6",
                     text);
  if (!(square > 1e-5 && square < 10.0))
    return wrong_use("--square-mm {:g}: the side of a square between 0.01 and 10000 mm is expected",
                     square * 1e3);
  shape.square = square;
  return shape;
}

std::optional<std::vector<device::Pixel>> find_board_corners(std::span<const std::uint8_t> grey, int width,
                                                             int height, const BoardShape& shape,
                                                             int half_window) {
  if (!holds(grey, width, height)) return std::nullopt;
  const cv::Mat picture = picture_of(grey, width, height);
  const auto rough = rough_corners(picture, shape, false);
  if (rough.empty()) return std::nullopt;
  return refined(picture, rough, half_window > 0 ? half_window : fitted_half_window(rough, shape));
}

std::vector<std::uint8_t> grey_from_rgb(std::span<const std::uint8_t> rgb) {
  std::vector<std::uint8_t> grey(rgb.size() / 3);
  for (std::size_t i = 0; i < grey.size(); ++i)  // weights of ITU-R BT.601, in 256ths
    grey[i] = static_cast<std::uint8_t>(
        (77u * rgb[3 * i] + 150u * rgb[3 * i + 1] + 29u * rgb[3 * i + 2] + 128u) >> 8);
  return grey;
}

Expected<BoardViews> read_board_images(const std::string& pattern, const BoardShape& shape,
                                       std::optional<int> half_window) {
  int goes_on = 0;
  BoardShape seen = shape;
  std::vector<std::vector<device::Pixel>> fitted;  // the same views with windows fitted to them
  std::size_t too_small = 0;                       // views with squares too small for the usual window
  auto views = read_views_of_images(
      pattern,
      [&](std::span<const std::uint8_t> grey, int width, int height,
          const std::string& name) -> std::optional<BoardView> {
        const cv::Mat picture = picture_of(grey, width, height);
        const auto rough = rough_corners(picture, shape, true);
        if (rough.empty()) return std::nullopt;
        const int fits = fitted_half_window(rough, shape), wanted = half_window.value_or(kUsualHalfWindow);
        BoardView view{name, board_points(shape), refined(picture, rough, wanted > 0 ? wanted : fits)};
        if (!half_window) fitted.push_back(refined(picture, rough, fits));
        too_small += fits < kUsualHalfWindow ? 1 : 0;
        const auto more = board_continuation(grey, width, height, shape, view.image);
        goes_on += more.columns + more.rows > 0 ? 1 : 0;
        seen.columns = std::max(seen.columns, shape.columns + more.columns);
        seen.rows = std::max(seen.rows, shape.rows + more.rows);
        return view;
      });
  if (!views) return views;
  views->goes_on = goes_on, views->seen_shape = seen;
  if (half_window || 2 * too_small <= views->views.size()) return views;
  for (std::size_t i = 0; i < fitted.size(); ++i) views->views[i].image = std::move(fitted[i]);
  views->doubt = fmt::format(
      "the board's squares are small: windows fitted to each view were taken around the corners, not {} px "
      "as usual",
      kUsualHalfWindow);
  return views;
}

Expected<BoardViews> read_views_of_images(const std::string& pattern, const FindBoard& find) {
  const auto files = matching_files(pattern);
  if (files.empty())
    return wrong_use("{}: no such file; a path or a quoted pattern such as 'boards/*.jpg' is expected",
                     pattern);
  BoardViews result;
  std::string hashes;
  for (const auto& file : files) {
    const auto bytes = read_file(file, kMostPictureBytes);
    if (!bytes) return tl::unexpected(bytes.error());
    if (const auto size = picture_size(*bytes, file); !size) return tl::unexpected(size.error());
    hashes += content_hash(*bytes);
    cv::Mat image;
    try {
      const cv::Mat raw(1, static_cast<int>(bytes->size()), CV_8UC1, const_cast<char*>(bytes->data()));
      image = cv::imdecode(raw, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      image.release();
    }
    if (image.empty())
      return wrong_use("{}: is not an image this program can read; JPEG or PNG is expected", file);
    if (result.width == 0) result.width = image.cols, result.height = image.rows;
    if (image.cols != result.width || image.rows != result.height)
      return wrong_use("{}: is {}x{} px, but {} is {}x{}; one camera at one resolution is expected", file,
                       image.cols, image.rows, files.front(), result.width, result.height);
    const std::string name = std::filesystem::path(file).filename().string();
    const auto size = static_cast<std::size_t>(image.cols) * static_cast<std::size_t>(image.rows);
    if (auto view = find({image.data, size}, image.cols, image.rows, name))  // decoded: no gaps between rows
      result.views.push_back(std::move(*view));
    else
      result.not_found.push_back(name);
  }
  result.data_hash = content_hash(hashes);
  return result;
}

Expected<BoardViews> read_board_corners(const std::string& file, const BoardShape& shape) {
  const auto content = read_file(file);
  if (!content) return tl::unexpected(content.error());
  return parse_board_corners(*content, file, shape);
}

Expected<BoardViews> parse_board_corners(std::string_view content, const std::string& source,
                                         const BoardShape& shape) {
  const auto table = parse_csv(content, source);
  if (!table) return tl::unexpected(table.error());
  std::vector<std::size_t> at;
  for (const char* name : {"image", "board_x_squares", "board_y_squares", "u_px", "v_px"}) {
    const auto column = table->require(name);
    if (!column) return tl::unexpected(column.error());
    at.push_back(*column);
  }
  if (table->rows.empty())
    return wrong_use("{}: holds a header but no corners; at least one row is expected", source);
  const auto width = table->find("width_px"), height = table->find("height_px");
  constexpr double kLargestImage = 1e5;  // px
  std::vector<std::size_t> in_pixels{at[3], at[4]};
  for (const auto& column : {width, height})
    if (column) in_pixels.push_back(*column);
  if (const auto fine = table->require_within(in_pixels, kLargestImage); !fine)
    return tl::unexpected(fine.error());
  BoardViews result;
  result.data_hash = content_hash(content);
  std::set<std::tuple<std::size_t, int, int>> seen;  // view and square
  std::map<std::string, std::size_t> view_of;
  for (std::size_t i = 0; i < table->rows.size(); ++i) {
    const auto& row = table->rows[i];
    const auto where = fmt::format("{}:{}", source, table->line[i]);
    const double x = row[at[1]], y = row[at[2]];
    if (x != std::floor(x) || y != std::floor(y) || x < 0 || y < 0 || x >= shape.columns || y >= shape.rows)
      return wrong_use(
          "{}: corner at square ({:g}, {:g}) is not on a board of {}x{} inner corners; check --board", where,
          x, y, shape.columns, shape.rows);
    const auto& image = table->text[i][at[0]];
    const auto [known, is_new] = view_of.try_emplace(image, result.views.size());
    if (is_new) result.views.push_back({image, {}, {}});
    BoardView& view = result.views[known->second];
    if (!seen.insert({known->second, static_cast<int>(x), static_cast<int>(y)}).second)
      return wrong_use("{}: corner ({:g}, {:g}) of '{}' is given twice; remove one", where, x, y,
                       excerpt(image));
    view.board.push_back(shape.square * Vector3(x, y, 0));
    view.image.emplace_back(row[at[3]], row[at[4]]);
    if (width && height) {
      const int w = static_cast<int>(row[*width]), h = static_cast<int>(row[*height]);
      if (result.width != 0 && (w != result.width || h != result.height))
        return wrong_use(
            "{}: image size {}x{} differs from {}x{} above; one camera at one resolution is expected", where,
            w, h, result.width, result.height);
      if (w < 1 || h < 1 || w > 100000 || h > 100000)
        return wrong_use("{}: image size {}x{} px is impossible", where, w, h);
      result.width = w, result.height = h;
    }
  }
  return result;
}

}  // namespace palpate::vision
