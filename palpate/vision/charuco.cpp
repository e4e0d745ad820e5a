#include "palpate/vision/charuco.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "palpate/core/text.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/internal/grey_picture.h"

namespace palpate::vision {
namespace {

constexpr int kFewestCorners = 6;
constexpr double kPaperSd = 1e-4;  // m
// Of the start's pose: wide enough that the image alone decides.
constexpr double kStartTurn = 0.5, kStartShift = 0.5;  // rad, m
constexpr int kFewestStrangers = 3;  // markers of another dictionary: fewer may be misread texture

// OpenCV's list has the same order as ours.
cv::Ptr<cv::aruco::Dictionary> dictionary_named(const std::string& name) {
  const auto& known = device::charuco_dictionaries();
  const auto at = std::find(known.begin(), known.end(), name);
  if (at == known.end()) throw std::invalid_argument("charuco: no dictionary " + name);
  return cv::aruco::getPredefinedDictionary(static_cast<int>(at - known.begin()));
}

struct Markers {
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> corners;
};

Markers read_markers(const cv::Mat& grey, const std::string& dictionary) {
  Markers found;
  const auto parameters = cv::aruco::DetectorParameters::create();
  try {
    cv::aruco::detectMarkers(grey, dictionary_named(dictionary), found.corners, found.ids, parameters);
  } catch (const cv::Exception&) {
    found = {};
  }
  return found;
}

// The plane's map from board to pixels around one marker.
std::optional<Eigen::Matrix3d> local_map(const std::array<Vector3, 4>& board,
                                         const std::vector<cv::Point2f>& image) {
  Eigen::Matrix<double, 8, 8> A = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> b;
  const Vector3 origin = 0.5 * (board[0] + board[2]);
  const double scale = 1.0 / (board[1] - board[0]).norm();
  for (Eigen::Index k = 0; k < 4; ++k) {
    const Vector3 p = scale * (board[static_cast<std::size_t>(k)] - origin);
    const cv::Point2f& u = image[static_cast<std::size_t>(k)];
    A.row(2 * k) << p.x(), p.y(), 1, 0, 0, 0, -u.x * p.x(), -u.x * p.y();
    A.row(2 * k + 1) << 0, 0, 0, p.x(), p.y(), 1, -u.y * p.x(), -u.y * p.y();
    b[2 * k] = u.x, b[2 * k + 1] = u.y;
  }
  const Eigen::Matrix<double, 8, 1> h = A.fullPivLu().solve(b);
  if (!h.allFinite()) return std::nullopt;
  Eigen::Matrix3d H, to_marker;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0;
  to_marker << scale, 0, -scale * origin.x(), 0, scale, -scale * origin.y(), 0, 0, 1;
  return H * to_marker;
}

device::Pixel mapped(const Eigen::Matrix3d& H, const Vector3& p) {
  return (H * Vector3(p.x(), p.y(), 1.0)).hnormalized();
}

CharucoSight corners_of_board(const cv::Mat& grey, const device::CharucoBoard& board) {
  CharucoSight sight;
  const Markers found = read_markers(grey, board.dictionary);
  std::map<int, Eigen::Matrix3d> maps;
  std::map<int, const std::vector<cv::Point2f>*> outlines;
  for (std::size_t k = 0; k < found.ids.size(); ++k) {
    const int id = found.ids[k];
    if (id >= board.markers()) {
      ++sight.strangers;
      continue;
    }
    ++sight.markers;
    if (const auto H = local_map(board.marker_corners(id), found.corners[k])) {
      maps[id] = *H;
      outlines[id] = &found.corners[k];
    }
  }
  for (int i = 0; i < board.corners(); ++i) {
    const auto beside = board.markers_at(i);
    if (!maps.contains(beside[0]) || !maps.contains(beside[1])) continue;
    const device::Pixel one = mapped(maps[beside[0]], board.corner(i)),
                        two = mapped(maps[beside[1]], board.corner(i));
    const device::Pixel start = 0.5 * (one + two);
    // How far, along the picture's axes, to the nearest corner of a marker: its edges must stay outside.
    double room = 1e9;
    for (const int id : beside)
      for (const auto& u : *outlines[id])
        room = std::min(room, std::max(std::abs(u.x - start.x()), std::abs(u.y - start.y())));
    // Markers that disagree are not the two that stand here.
    if (!start.allFinite() || (one - two).norm() > std::max(2.0, room)) {
      ++sight.contradictions;
      continue;
    }
    const int half = std::clamp(static_cast<int>(room - 1.0), 2, 9);
    if (start.x() < half + 2 || start.y() < half + 2 || start.x() > grey.cols - half - 3 ||
        start.y() > grey.rows - half - 3)
      continue;
    std::vector<cv::Point2f> corner{{static_cast<float>(start.x()), static_cast<float>(start.y())}};
    cv::cornerSubPix(grey, corner, {half, half}, {-1, -1},
                     {cv::TermCriteria::EPS | cv::TermCriteria::MAX_ITER, 30, 0.001});
    const device::Pixel refined(corner.front().x, corner.front().y);
    if (!((refined - start).norm() <= half)) continue;  // it ran away to another edge
    sight.corners.push_back(i);
    sight.pixels.push_back(refined);
  }
  return sight;
}

// At least two rows and two columns: corners in one line fix no plane.
bool spread(const device::CharucoBoard& board, const std::vector<int>& corners) {
  const int along = board.columns - 1;
  bool rows = false, columns = false;
  for (const int i : corners) {
    rows = rows || i / along != corners.front() / along;
    columns = columns || i % along != corners.front() % along;
  }
  return rows && columns;
}

}  // namespace

CharucoSight find_charuco(std::span<const std::uint8_t> grey, int width, int height,
                          const device::CharucoBoard& board) {
  return holds(grey, width, height) ? corners_of_board(picture_of(grey, width, height), board)
                                    : CharucoSight{};
}

BoardView charuco_view(const device::CharucoBoard& board, const CharucoSight& sight, std::string name) {
  BoardView view{std::move(name), {}, sight.pixels};
  for (const int i : sight.corners) view.board.push_back(board.corner(i));
  return view;
}

Expected<BoardViews> read_charuco_images(const std::string& pattern, const device::CharucoBoard& board) {
  return read_views_of_images(
      pattern,
      [&board](std::span<const std::uint8_t> grey, int width, int height,
               const std::string& name) -> std::optional<BoardView> {
        const auto sight = find_charuco(grey, width, height, board);
        if (static_cast<int>(sight.corners.size()) < kFewestCorners || !spread(board, sight.corners))
          return std::nullopt;
        return charuco_view(board, sight, name);
      });
}

std::optional<std::string> other_dictionary(std::span<const std::uint8_t> grey, int width, int height,
                                            const std::string& than) {
  if (!holds(grey, width, height)) return std::nullopt;
  std::optional<std::string> name;
  std::size_t most = kFewestStrangers - 1;
  // The largest of each kind holds the smaller ones, with fewer bits repaired.
  for (const char* kind : {"4x4_1000", "5x5_1000", "6x6_1000", "7x7_1000"}) {
    if (than.starts_with(std::string_view(kind).substr(0, 3))) continue;
    const auto found = read_markers(picture_of(grey, width, height), kind);
    if (found.ids.size() <= most) continue;
    most = found.ids.size();
    const int highest = *std::max_element(found.ids.begin(), found.ids.end());
    const char* count = highest < 50 ? "_50" : highest < 100 ? "_100" : highest < 250 ? "_250" : "_1000";
    name = std::string(kind).substr(0, 3) + count;
  }
  return name;
}

std::vector<rig::Landmark> charuco_landmarks(const device::CharucoBoard& board,
                                             const Pose<World, Board>& X_world_board) {
  std::vector<rig::Landmark> landmarks;
  for (int i = 0; i < board.corners(); ++i) {
    rig::Landmark landmark;
    landmark.place = X_world_board * Point<Board>{board.corner(i)};
    landmark.covariance = kPaperSd * kPaperSd * Matrix3::Identity();
    landmark.normal = X_world_board.rotation * -Vector3::UnitZ();
    landmarks.push_back(landmark);
  }
  return landmarks;
}

Expected<RefinedPose> camera_from_charuco(const device::CameraModel& camera,
                                          const device::CharucoBoard& board,
                                          const Pose<World, Board>& X_world_board, const CharucoSight& sight,
                                          const std::optional<Pose<World, CameraOptical>>& near) {
  const auto seen = static_cast<int>(sight.corners.size());
  if (seen < kFewestCorners || !spread(board, sight.corners)) {
    if (sight.markers == 0 && sight.strangers > 0)
      return refused(
          "only markers of another board ({} of dictionary {}); put the board of the rig file there",
          sight.strangers, board.dictionary);
    if (sight.contradictions > seen)
      return refused(
          "its markers do not stand as on a board of {}x{} squares with markers of {:.2f} of their side; the "
          "rig file's board and the print must belong together",
          board.columns, board.rows, board.marker / board.square);
    return refused(
        "{} of its {} corners are seen, at least {} in two rows are needed; turn the camera "
        "towards it, uncover it, or come nearer",
        seen, board.corners(), kFewestCorners);
  }
  const auto landmarks = charuco_landmarks(board, X_world_board);
  std::vector<Sighting> sightings;
  for (std::size_t k = 0; k < sight.corners.size(); ++k)
    sightings.push_back({static_cast<std::size_t>(sight.corners[k]), sight.pixels[k]});
  RefinementOptions options;
  options.pixel_sd = kCharucoCornerSd;
  options.least_inliers = kFewestCorners;
  options.max_iterations = 20;
  Matrix6 wide = Matrix6::Zero();
  wide.diagonal() << Vector3::Constant(kStartTurn * kStartTurn), Vector3::Constant(kStartShift * kStartShift);
  const auto from = [&](const Pose<World, CameraOptical>& start) {
    RefinedPose pose = refine_camera_pose(camera, {start, wide}, landmarks, sightings, options);
    // A lens or a print worse than stated: what the corners leave counts.
    if (pose.misfit > 1.0) pose.covariance *= pose.misfit * pose.misfit;
    return pose;
  };
  if (near)
    if (auto pose = from(*near); pose.refined) return pose;
  const auto fresh = board_pose(camera, charuco_view(board, sight, "picture"));
  if (!fresh)
    return refused(
        "its corners do not lie as on a board of {}x{} squares; the rig file's board, its lens and "
        "the print must belong together",
        board.columns, board.rows);
  if (fresh->value.ambiguous)
    return refused("it is too small or too little of it is seen to tell how it is tilted; come nearer");
  const auto pose = from(X_world_board * fresh->value.X_camera_board.inverse());
  if (!pose.refined)
    return refused(
        "its corners contradict each other ({} of {} agree); calibrate the lens again, or press the "
        "sheet flat",
        pose.inliers, seen);
  return pose;
}

std::vector<std::vector<bool>> charuco_bits(const std::string& dictionary, int id) {
  const auto set = dictionary_named(dictionary);
  const int side = set->markerSize + 2;  // with its border
  cv::Mat drawn;
  set->drawMarker(id, side, drawn, 1);
  std::vector<std::vector<bool>> bits(static_cast<std::size_t>(side));
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      bits[static_cast<std::size_t>(row)].push_back(drawn.at<std::uint8_t>(row, column) < 128);
  return bits;
}

}  // namespace palpate::vision
