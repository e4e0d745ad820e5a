#include "palpate/evaluation/timecode_finder.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "palpate/device/timecode.h"

namespace palpate::evaluation {
namespace {

constexpr int kNeighbourhood = 24;     // px each way; more than a frame is thick
constexpr int kBrighter = 8;           // grey levels above the neighbourhood's mean, after smoothing
constexpr double kLeastBlockPx = 3.0;  // high; its frame is half as thick
constexpr double kFrameWide = device::kPanelWide - 1.0,
                 kFrameHigh = device::kPanelHigh - 1.0;    // blocks, its outer edge
constexpr double kFrameMiddle = device::kPanelRim - 0.75;  // blocks from the panel's edge
constexpr double kSlant = 2.5;      // a frame may look so much shorter or lower than it is
constexpr double kFrameSeen = 0.9;  // share of each side that must be brighter than the margin
constexpr double kLeastStep = 6.0;  // grey levels between frame and margin

// The picture's grey levels, smoothed over 3 x 3, of an area; and sums of all above and left of a pixel.
struct Grey {
  Grey(std::span<const std::uint8_t> rgb, int width, int height, const PictureArea& a)
      : area(a), wide(a.right - a.left), high(a.bottom - a.top) {
    const auto pixel = [&](int u, int v) {
      u = std::clamp(u, 0, width - 1), v = std::clamp(v, 0, height - 1);
      const std::uint8_t* p =
          rgb.data() +
          3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u));
      return static_cast<std::uint32_t>(p[0]) + 2u * p[1] + p[2];
    };
    const auto row_bytes = static_cast<std::size_t>(wide + 2);
    std::vector<std::uint32_t> across(row_bytes * static_cast<std::size_t>(high + 2));
    for (int v = -1; v <= high; ++v) {
      std::uint32_t* out = across.data() + static_cast<std::size_t>(v + 1) * row_bytes;
      for (int u = -1; u <= wide; ++u) out[u + 1] = pixel(area.left + u, area.top + v);
      std::uint32_t before = out[0];
      for (int u = 1; u <= wide; ++u) {
        const std::uint32_t here = out[u];
        out[u] += before + out[u + 1];
        before = here;
      }
    }
    level.resize(static_cast<std::size_t>(wide) * static_cast<std::size_t>(high));
    sums.assign(static_cast<std::size_t>(wide + 1) * static_cast<std::size_t>(high + 1), 0);
    for (int v = 0; v < high; ++v) {
      const std::uint32_t* above = across.data() + static_cast<std::size_t>(v) * row_bytes;
      std::uint32_t along = 0;
      for (int u = 0; u < wide; ++u) {
        const std::uint32_t sum = above[u + 1] + above[row_bytes + static_cast<std::size_t>(u + 1)] +
                                  above[2 * row_bytes + static_cast<std::size_t>(u + 1)];
        const std::uint8_t value = static_cast<std::uint8_t>(sum / 36);
        level[at(u, v)] = value;
        along += value;
        sums[sum_at(u + 1, v + 1)] = sums[sum_at(u + 1, v)] + along;
      }
    }
  }
  std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(wide) + static_cast<std::size_t>(u);
  }
  std::size_t sum_at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(wide + 1) + static_cast<std::size_t>(u);
  }
  bool bright(int u, int v) const {
    const int left = std::max(0, u - kNeighbourhood), right = std::min(wide, u + kNeighbourhood + 1);
    const int top = std::max(0, v - kNeighbourhood), bottom = std::min(high, v + kNeighbourhood + 1);
    const std::uint32_t sum = sums[sum_at(right, bottom)] - sums[sum_at(left, bottom)] -
                              sums[sum_at(right, top)] + sums[sum_at(left, top)];
    const int count = (right - left) * (bottom - top);
    return (static_cast<int>(level[at(u, v)]) - kBrighter) * count > static_cast<int>(sum);
  }
  // Between pixels, of the whole picture; nothing outside of the area.
  std::optional<double> between(const device::Pixel& p) const {
    const double x = p.x() - area.left, y = p.y() - area.top;
    if (!(x >= 0 && y >= 0 && x <= wide - 1 && y <= high - 1)) return std::nullopt;
    const int u = std::min(static_cast<int>(x), wide - 2), v = std::min(static_cast<int>(y), high - 2);
    const double s = x - u, t = y - v;
    return (1 - t) * ((1 - s) * level[at(u, v)] + s * level[at(u + 1, v)]) +
           t * ((1 - s) * level[at(u, v + 1)] + s * level[at(u + 1, v + 1)]);
  }

  PictureArea area;
  int wide, high;
  std::vector<std::uint8_t> level;
  std::vector<std::uint32_t> sums;
};

// A region of bright pixels: its outermost ones towards upper left, upper right, lower right, lower left.
struct Region {
  std::array<int, 4> reach;
  std::array<std::array<int, 2>, 4> corner;
  Region() { reach.fill(std::numeric_limits<int>::min()); }
  void take(int u, int v) {
    const std::array<int, 4> here{-u - v, u - v, u + v, v - u};
    for (std::size_t i = 0; i < 4; ++i)
      if (here[i] > reach[i]) reach[i] = here[i], corner[i] = {u, v};
  }
  void take(const Region& other) {
    for (const auto& c : other.corner) take(c[0], c[1]);
  }
};

// Bright pixels joined by their sides or corners, row by row: runs that touch a run of the row above belong
// to its region.
std::vector<Region> regions_of(const Grey& grey) {
  struct Run {
    int from, to;
    std::size_t region;
  };
  std::vector<Region> regions;
  std::vector<std::size_t> parent;
  const auto root = [&parent](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<Run> above, here;
  for (int v = 0; v < grey.high; ++v) {
    here.clear();
    std::size_t next_above = 0;
    for (int u = 0; u < grey.wide; ++u) {
      if (!grey.bright(u, v)) continue;
      Run run{u, u, parent.size()};
      while (run.to + 1 < grey.wide && grey.bright(run.to + 1, v)) ++run.to;
      while (next_above < above.size() && above[next_above].to < run.from - 1) ++next_above;
      for (std::size_t i = next_above; i < above.size() && above[i].from <= run.to + 1; ++i) {
        const std::size_t other = root(above[i].region);
        if (run.region == parent.size()) {
          run.region = other;
        } else if (root(run.region) != other) {
          const std::size_t mine = root(run.region);
          regions[mine].take(regions[other]);
          parent[other] = mine;
        }
      }
      if (run.region == parent.size()) {
        parent.push_back(run.region);
        regions.emplace_back();
      }
      Region& region = regions[root(run.region)];
      region.take(run.from, v);
      region.take(run.to, v);
      here.push_back(run);
      u = run.to;
    }
    std::swap(above, here);
  }
  std::vector<Region> whole;
  for (std::size_t i = 0; i < regions.size(); ++i)
    if (parent[i] == i) whole.push_back(regions[i]);
  return whole;
}

// The corners of a frame's outer edge, if the region's shape can be one.
std::optional<TimecodeCorners> frame_of(const Region& region, const PictureArea& area) {
  TimecodeCorners c;
  // A pixel's bright half reaches beyond its centre.
  constexpr std::array<std::array<double, 2>, 4> kOut{{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
  for (std::size_t i = 0; i < 4; ++i)
    c[i] = device::Pixel(area.left + region.corner[i][0] + kOut[i][0],
                         area.top + region.corner[i][1] + kOut[i][1]);
  const double top = (c[1] - c[0]).norm(), bottom = (c[2] - c[3]).norm(), left = (c[3] - c[0]).norm(),
               right = (c[2] - c[1]).norm();
  const double wide = 0.5 * (top + bottom), high = 0.5 * (left + right);
  if (std::min(left, right) < kFrameHigh * kLeastBlockPx) return std::nullopt;
  const double shape = wide / high / (kFrameWide / kFrameHigh);
  if (shape < 1.0 / kSlant || shape > kSlant) return std::nullopt;
  if (std::max(top, bottom) > 2.0 * std::min(top, bottom) ||
      std::max(left, right) > 2.0 * std::min(left, right))
    return std::nullopt;
  for (std::size_t i = 0; i < 4; ++i) {  // convex, corner by corner, as y runs down
    const device::Pixel a = c[(i + 1) % 4] - c[i], b = c[(i + 2) % 4] - c[(i + 1) % 4];
    if (!(a.x() * b.y() - a.y() * b.x() > 0.0)) return std::nullopt;
  }
  return c;
}

// Along the middle of the frame, side by side, it is brighter than beside it in the margin; place by place,
// as light may fall off along it.
bool is_frame(const Grey& grey, const Matrix3& from_panel) {
  constexpr int kPlaces = 20;
  constexpr double kFrame = kFrameMiddle, kMargin = device::kPanelRim - 0.25;
  const auto level = [&](double x, double y) {
    return grey.between((from_panel * Vector3(x, y, 1.0)).hnormalized());
  };
  for (int side = 0; side < 4; ++side) {
    int brighter = 0;
    for (int i = 0; i < kPlaces; ++i) {
      const auto at = [&](double rim) {
        const double along = (i + 0.5) / kPlaces;
        const double x = rim + (device::kPanelWide - 2 * rim) * along,
                     y = rim + (device::kPanelHigh - 2 * rim) * along;
        return side == 0   ? level(x, rim)
               : side == 1 ? level(device::kPanelWide - rim, y)
               : side == 2 ? level(x, device::kPanelHigh - rim)
                           : level(rim, y);
      };
      const auto frame = at(kFrame), margin = at(kMargin);
      if (!frame || !margin) return false;
      brighter += *frame - *margin > kLeastStep ? 1 : 0;
    }
    if (brighter < kFrameSeen * kPlaces) return false;
  }
  return true;
}

// Corners of the frame's middle line, between pixels: on each side the middle of brightness across the frame,
// place by place, and a line through them (total least squares). Nothing where a side cannot be told.
std::optional<TimecodeCorners> middle_of_frame(const Grey& grey, const Matrix3& from_panel) {
  constexpr int kPlaces = 24, kAcross = 13;
  constexpr double kReach =
      0.5;  // blocks either side of the middle: through border and margin to their middles
  std::array<Eigen::Vector3d, 4> lines;
  for (std::size_t side = 0; side < 4; ++side) {
    std::vector<device::Pixel> middles;
    for (int i = 0; i < kPlaces; ++i) {
      std::array<device::Pixel, kAcross> at;
      std::array<double, kAcross> levels{};
      double least = 255.0;
      bool whole = true;
      for (int k = 0; k < kAcross; ++k) {
        const double rim = kFrameMiddle + kReach * (2.0 * k / (kAcross - 1) - 1.0),
                     along = (i + 0.5) / kPlaces;
        const double x = device::kPanelRim + (device::kPanelWide - 2 * device::kPanelRim) * along,
                     y = device::kPanelRim + (device::kPanelHigh - 2 * device::kPanelRim) * along;
        const device::Pixel panel = side == 0   ? device::Pixel(x, rim)
                                    : side == 1 ? device::Pixel(device::kPanelWide - rim, y)
                                    : side == 2 ? device::Pixel(x, device::kPanelHigh - rim)
                                                : device::Pixel(rim, y);
        const auto n = static_cast<std::size_t>(k);
        at[n] = (from_panel * panel.homogeneous()).hnormalized();
        const auto level = grey.between(at[n]);
        whole = whole && level.has_value();
        levels[n] = level.value_or(0.0);
        least = std::min(least, levels[n]);
      }
      if (!whole) continue;
      device::Pixel sum = device::Pixel::Zero();
      double weights = 0.0;
      for (std::size_t k = 0; k < at.size(); ++k)
        sum += (levels[k] - least) * at[k], weights += levels[k] - least;
      if (weights > kLeastStep) middles.push_back(sum / weights);
    }
    if (middles.size() < kPlaces / 2) return std::nullopt;
    device::Pixel mean = device::Pixel::Zero();
    for (const auto& p : middles) mean += p / static_cast<double>(middles.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const auto& p : middles) spread += (p - mean) * (p - mean).transpose();
    const Eigen::Vector2d normal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(0);
    lines[side] = {normal.x(), normal.y(), -normal.dot(mean)};
  }
  TimecodeCorners corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d meet = lines[(i + 3) % 4].cross(lines[i]);
    if (std::abs(meet.z()) < 1e-6) return std::nullopt;
    corners[i] = meet.hnormalized();
  }
  return corners;
}

// From blocks of the panel to the picture, where a rectangle `rim` blocks inside of its edge has these
// corners.
Matrix3 panel_map(const TimecodeCorners& corners, double rim) {
  const double wide = device::kPanelWide - 2 * rim, high = device::kPanelHigh - 2 * rim;
  Matrix3 to_square = Matrix3::Identity();
  to_square(0, 0) = 1.0 / wide, to_square(1, 1) = 1.0 / high;
  to_square(0, 2) = -rim / wide, to_square(1, 2) = -rim / high;
  return device::from_unit_square(corners) * to_square;
}

}  // namespace

std::vector<TimecodeCorners> find_timecodes(std::span<const std::uint8_t> rgb, int width, int height,
                                            const std::optional<PictureArea>& wanted) {
  PictureArea area = wanted.value_or(PictureArea{0, 0, width, height});
  area = {std::max(0, area.left), std::max(0, area.top), std::min(width, area.right),
          std::min(height, area.bottom)};
  if (area.right - area.left < 2 || area.bottom - area.top < 2 ||
      rgb.size() < 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return {};
  const Grey grey(rgb, width, height, area);
  std::vector<std::pair<double, TimecodeCorners>> found;
  for (const auto& region : regions_of(grey)) {
    const auto frame = frame_of(region, area);
    if (!frame) continue;
    Matrix3 from_panel = panel_map(*frame, kFrameMiddle - 0.25);
    if (!is_frame(grey, from_panel)) continue;
    for (int round = 0; round < 2; ++round)
      if (const auto middle = middle_of_frame(grey, from_panel))
        from_panel = panel_map(*middle, kFrameMiddle);
    TimecodeCorners timecode;
    const std::array<device::Pixel, 4> blocks{
        device::Pixel(device::kPanelRim, device::kPanelRim),
        device::Pixel(device::kPanelWide - device::kPanelRim, device::kPanelRim),
        device::Pixel(device::kPanelWide - device::kPanelRim, device::kPanelHigh - device::kPanelRim),
        device::Pixel(device::kPanelRim, device::kPanelHigh - device::kPanelRim)};
    for (std::size_t i = 0; i < 4; ++i) timecode[i] = (from_panel * blocks[i].homogeneous()).hnormalized();
    found.emplace_back((timecode[2] - timecode[0]).squaredNorm(), timecode);
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<TimecodeCorners> timecodes;
  for (const auto& [size, timecode] : found) timecodes.push_back(timecode);
  return timecodes;
}

}  // namespace palpate::evaluation
