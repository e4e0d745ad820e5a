#include "palpate/calibration/pivot_rests.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/core/statistics.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kPieceTurn =
    radians_from_degrees(20.0);        // tells a tip to about ten times the tracker's noise
constexpr double kLongestPiece = 8.0;  // s
constexpr std::size_t kPieces = 400, kFewest = 8;
constexpr double kLeastTilt = 0.03;    // rms turn about the weakest axis of a piece
constexpr std::size_t kLookEvery = 8;  // poses by which a longer piece grows
constexpr int kRounds = 10;
constexpr double kNoisy = 4.0;  // times the stillest tenth's spread is still

// What a stretch of poses says of a tip: sums, so that any tip's spread in it costs nothing.
struct Stretch {
  Matrix3 R = Matrix3::Zero();
  Vector3 p = Vector3::Zero(), Rtp = Vector3::Zero();
  double pp = 0.0, count = 0.0;

  void add(const PivotPose& pose) {
    const Matrix3 turned = pose.rotation.toRotationMatrix();
    R += turned;
    p += pose.translation;
    Rtp += turned.transpose() * pose.translation;
    pp += pose.translation.squaredNorm();
    count += 1.0;
  }
  // A tip = b are the normal equations of R t + p = const.
  Matrix3 A() const { return count * Matrix3::Identity() - R.transpose() * R / count; }
  Vector3 b() const { return R.transpose() * p / count - Rtp; }
  // Mean square distance of a tip from its mean place.
  double spread(const Vector3& tip) const {
    const double square = tip.dot(A() * tip) - 2.0 * tip.dot(b()) + pp - p.squaredNorm() / count;
    return std::sqrt(std::max(0.0, square / count));
  }
};

Stretch stretch_of(const std::vector<PivotPose>& poses, std::size_t first, std::size_t last) {
  // From a pose of its own, so that the sums keep their digits.
  const Vector3 origin = poses[first].translation;
  Stretch stretch;
  for (std::size_t i = first; i <= last; ++i) {
    PivotPose pose = poses[i];
    pose.translation -= origin;
    stretch.add(pose);
  }
  return stretch;
}

bool tilts(const Stretch& piece) {
  return symmetric_eigenvalues(piece.A())[0] >= kLeastTilt * kLeastTilt * piece.count;
}

// From one pose until the marker has turned enough; where `about_all_axes`, until a tip can be told. A marker that is swung quickly
// turns about one axis in each of the shorter pieces, and these tell none.
std::vector<Stretch> pieces_of(const std::vector<PivotPose>& poses, bool about_all_axes) {
  std::vector<Stretch> pieces;
  const std::size_t stride = std::max<std::size_t>(1, poses.size() / kPieces);
  for (std::size_t i = 0; i < poses.size(); i += stride) {
    double turn = 0.0;
    for (std::size_t j = i + kFewest; j < poses.size() && *poses[j].time_s - *poses[i].time_s < kLongestPiece;
         ++j) {
      turn = std::max(turn, poses[i].rotation.angularDistance(poses[j].rotation));
      if (turn <= kPieceTurn || (about_all_axes && (j - i) % kLookEvery != 0)) continue;
      auto piece = stretch_of(poses, i, j);
      if (about_all_axes && !tilts(piece)) continue;
      pieces.push_back(piece);
      break;
    }
  }
  return pieces;
}

// The tip of one piece by which the stillest third of the recording is stillest.
std::optional<Vector3> first_tip(const std::vector<Stretch>& pieces) {
  std::optional<Vector3> best;
  double least = 0.0;
  std::vector<double> spreads(pieces.size());
  for (const auto& piece : pieces) {
    if (!tilts(piece)) continue;
    const Vector3 tip = solve_symmetric(piece.A(), piece.b());
    for (std::size_t i = 0; i < pieces.size(); ++i) spreads[i] = pieces[i].spread(tip);
    const double third = quantile(spreads, 1.0 / 3.0);
    if (best && third >= least) continue;
    best = tip;
    least = third;
  }
  return best;
}

class Rests {
 public:
  Rests(const std::vector<PivotPose>& poses, const PivotRestsOptions& options)
      : poses_(poses), options_(options) {}

  std::vector<PivotRest> at(const Vector3& tip) const {
    std::vector<Vector3> places(poses_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i)
      places[i] = poses_[i].rotation * tip + poses_[i].translation;
    const auto spreads = local_spreads(places);
    const double still = std::max(options_.still, kNoisy * quantile(spreads, 0.1));
    std::vector<PivotRest> rests;
    for (std::size_t i = 0; i < places.size();) {
      if (spreads[i] > still) {
        ++i;
        continue;
      }
      std::size_t last = i;
      Vector3 mean = places[i];
      while (last + 1 < places.size() && spreads[last + 1] <= still &&
             (places[last + 1] - mean).norm() < options_.apart) {
        ++last;
        mean += (places[last] - mean) / static_cast<double>(last - i + 1);
      }
      if (is_rest(i, last)) rests.push_back({i, last});
      i = last + 1;
    }
    return rests;
  }

  Vector3 tip_of(const std::vector<PivotRest>& rests) const {
    Matrix3 A = Matrix3::Zero();
    Vector3 b = Vector3::Zero();
    for (const auto& rest : rests) {
      const auto stretch = stretch_of(poses_, rest.first, rest.last);
      A += stretch.A();
      b += stretch.b();
    }
    return solve_symmetric(A, b);
  }

 private:
  bool is_rest(std::size_t first, std::size_t last) const {
    if (last - first + 1 < kFewest || *poses_[last].time_s - *poses_[first].time_s < options_.least_s)
      return false;
    double turn = 0.0;
    for (std::size_t i = first; i <= last; ++i)
      turn = std::max(turn, poses_[first].rotation.angularDistance(poses_[i].rotation));
    return turn > options_.least_turn;
  }

  // Of each place and those within half a window of it.
  std::vector<double> local_spreads(const std::vector<Vector3>& places) const {
    std::vector<double> spreads(places.size());
    std::size_t first = 0, last = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double now = *poses_[i].time_s, half = 0.5 * options_.window_s;
      while (*poses_[first].time_s < now - half) ++first;
      while (last + 1 < places.size() && *poses_[last + 1].time_s <= now + half) ++last;
      Vector3 mean = Vector3::Zero();
      const auto count = static_cast<double>(last - first + 1);
      for (std::size_t k = first; k <= last; ++k) mean += places[k] / count;
      double square = 0.0;
      for (std::size_t k = first; k <= last; ++k) square += (places[k] - mean).squaredNorm() / count;
      // Nothing near by: nobody knows whether it stands still.
      spreads[i] = count < 3.0 ? options_.apart : std::sqrt(square);
    }
    return spreads;
  }

  const std::vector<PivotPose>& poses_;
  const PivotRestsOptions& options_;
};

bool same(const std::vector<PivotRest>& a, const std::vector<PivotRest>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PivotRest& x, const PivotRest& y) {
    return x.first == y.first && x.last == y.last;
  });
}

std::size_t poses_in(const std::vector<PivotRest>& rests) {
  std::size_t count = 0;
  for (const auto& rest : rests) count += rest.last - rest.first + 1;
  return count;
}

// The rests of a first tip, improved by all of them together until they stay the same.
std::vector<PivotRest> rests_from(const std::optional<Vector3>& tip, const std::vector<PivotPose>& poses,
                                  const PivotRestsOptions& options) {
  if (!tip) return {};
  const Rests finder(poses, options);
  auto rests = finder.at(*tip);
  for (int round = 0; round < kRounds && !rests.empty(); ++round) {
    auto next = finder.at(finder.tip_of(rests));
    const bool done = same(next, rests);
    rests = std::move(next);
    if (done) break;
  }
  return rests;
}

}  // namespace

Expected<std::vector<PivotRest>> find_pivot_rests(const std::vector<PivotPose>& poses,
                                                  const PivotRestsOptions& options) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i].time_s) return refused("rests: pose {} has no time, by which they are told", i + 1);
    if (i > 0 && *poses[i].time_s < *poses[i - 1].time_s)
      return refused("rests: pose {} is earlier than the one before it", i + 1);
    if (!poses[i].rotation.coeffs().allFinite() || !poses[i].translation.allFinite())
      return refused("rests: pose {} is not a number", i + 1);
  }
  // The one that explains more of the recording.
  std::vector<PivotRest> rests = rests_from(first_tip(pieces_of(poses, false)), poses, options);
  if (auto others = rests_from(first_tip(pieces_of(poses, true)), poses, options);
      poses_in(others) > poses_in(rests))
    rests = std::move(others);
  if (rests.empty())
    return refused(
        "rests: in none of the {} poses does a tip stay in its place for {:g} s while its marker turns by "
        "{:.0f} "
        "degrees; rest it in a hollow and swing the marker",
        poses.size(), options.least_s, degrees_from_radians(options.least_turn));
  return rests;
}

void put_segments(const std::vector<PivotRest>& rests, std::vector<PivotPose>& poses) {
  for (auto& pose : poses) pose.segment = -1;
  for (std::size_t s = 0; s < rests.size(); ++s)
    for (std::size_t i = rests[s].first; i <= rests[s].last; ++i) poses[i].segment = static_cast<int>(s);
}

}  // namespace palpate::calibration
