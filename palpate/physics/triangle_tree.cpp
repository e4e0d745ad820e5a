#include "palpate/physics/triangle_tree.h"

#include <algorithm>
#include <cmath>

namespace palpate::physics {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr std::size_t kBins = 16;
constexpr float kFar = std::numeric_limits<float>::infinity();

// The next float but one at most: always one step on, without asking whether the rounding went that way.
float rounded_down(double x) { return std::nextafter(static_cast<float>(x), -kFar); }
float rounded_up(double x) { return std::nextafter(static_cast<float>(x), kFar); }

}  // namespace

TriangleTree::TriangleTree(std::vector<Triangle>& triangles) {
  if (triangles.empty()) return;
  const auto count = static_cast<std::uint32_t>(triangles.size());
  bounds_.reserve(count);
  order_.reserve(count);
  for (const auto& t : triangles) {
    Bounds b{};
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double low = std::min({t[0][i], t[1][i], t[2][i]}), high = std::max({t[0][i], t[1][i], t[2][i]});
      b.low[static_cast<std::size_t>(i)] = rounded_down(low);
      b.high[static_cast<std::size_t>(i)] = rounded_up(high);
      extent_ = std::max({extent_, std::abs(low), std::abs(high)});
    }
    order_.push_back(static_cast<std::uint32_t>(bounds_.size()));
    bounds_.push_back(b);
  }
  leaves_.reserve(count / 2 + 1);
  nodes_.reserve(count / 4 + 1);
  root_ = build(range(0, count, 0), triangles);
  std::vector<Triangle> ordered;
  ordered.reserve(count);
  for (const auto i : order_) ordered.push_back(triangles[i]);
  triangles = std::move(ordered);
  bounds_ = {};
  nodes_.shrink_to_fit();
  leaves_.shrink_to_fit();
}

TriangleTree::Range TriangleTree::range(std::uint32_t first, std::uint32_t last, int depth) const {
  Range r{first, last, depth, {{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}}};
  for (std::uint32_t i = first; i < last; ++i) {
    const Bounds& b = bounds_[order_[i]];
    for (std::size_t k = 0; k < 3; ++k) {
      r.bounds.low[k] = std::min(r.bounds.low[k], b.low[k]);
      r.bounds.high[k] = std::max(r.bounds.high[k], b.high[k]);
    }
  }
  return r;
}

namespace {

// Half the surface of a box.
template <typename B>
float half_area(const B& b) {
  const float x = b.high[0] - b.low[0], y = b.high[1] - b.low[1], z = b.high[2] - b.low[2];
  return x * y + y * z + z * x;
}

template <typename B>
void grow_bounds(B& b, const B& other) {
  for (std::size_t k = 0; k < 3; ++k) {
    b.low[k] = std::min(b.low[k], other.low[k]);
    b.high[k] = std::max(b.high[k], other.high[k]);
  }
}

// What a run of triangles costs: leaves that have to be looked at.
float leaves_for(std::uint32_t triangles) {
  const std::uint32_t whole = (triangles + kLeafSize - 1) / kLeafSize;
  return static_cast<float>(whole);
}

}  // namespace

// Where the two parts' areas times their leaves are least, of 15 cuts across each axis.
std::uint32_t TriangleTree::split(const Range& whole) {
  const auto middle_of = [&](std::uint32_t i, std::size_t k) {
    return 0.5f * bounds_[i].low[k] + 0.5f * bounds_[i].high[k];
  };
  struct Bin {
    Bounds bounds{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
    std::uint32_t count = 0;
  };
  std::array<float, 3> low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  for (std::uint32_t i = whole.first; i < whole.last; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], middle_of(order_[i], k));
      high[k] = std::max(high[k], middle_of(order_[i], k));
    }
  }
  const auto bin_of = [&](std::uint32_t i, std::size_t k) {
    const float at = (middle_of(i, k) - low[k]) / (high[k] - low[k]) * static_cast<float>(kBins);
    return std::min(static_cast<std::size_t>(std::max(at, 0.0f)), kBins - 1);
  };
  float best = kFar;
  std::size_t axis = 3, cut = 0;
  for (std::size_t k = 0; k < 3 && whole.depth < kDeepest; ++k) {
    if (!(high[k] > low[k])) continue;
    std::array<Bin, kBins> bins;
    for (std::uint32_t i = whole.first; i < whole.last; ++i) {
      Bin& bin = bins[bin_of(order_[i], k)];
      grow_bounds(bin.bounds, bounds_[order_[i]]);
      ++bin.count;
    }
    std::array<float, kBins> right_cost;
    Bin side;
    for (std::size_t b = kBins - 1; b > 0; --b) {
      grow_bounds(side.bounds, bins[b].bounds);
      side.count += bins[b].count;
      right_cost[b] = side.count > 0 ? half_area(side.bounds) * leaves_for(side.count) : kFar;
    }
    side = {};
    for (std::size_t b = 1; b < kBins; ++b) {
      grow_bounds(side.bounds, bins[b - 1].bounds);
      side.count += bins[b - 1].count;
      if (side.count == 0) continue;
      const float cost = half_area(side.bounds) * leaves_for(side.count) + right_cost[b];
      if (cost < best) {
        best = cost;
        axis = k;
        cut = b;
      }
    }
  }
  const auto begin = order_.begin() + whole.first, end = order_.begin() + whole.last;
  if (axis < 3) {
    const auto at = std::partition(begin, end, [&](std::uint32_t i) { return bin_of(i, axis) < cut; });
    if (at != begin && at != end) return static_cast<std::uint32_t>(at - order_.begin());
  }
  // All in one place, or the tree grows too deep: two halves along the longest side.
  std::size_t longest = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (high[k] - low[k] > high[longest] - low[longest]) longest = k;
  }
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
    const float x = middle_of(a, longest), y = middle_of(b, longest);
    return x < y || (x == y && a < b);
  });
  return static_cast<std::uint32_t>(middle - order_.begin());
}

std::uint32_t TriangleTree::build(const Range& whole, const std::vector<Triangle>& triangles) {
  if (whole.last - whole.first <= kLeafSize) return add_leaf(whole, triangles);
  std::array<Range, 4> parts{whole};
  std::size_t count = 1;
  while (count < parts.size()) {  // the costliest part is split until there are four
    std::size_t chosen = parts.size();
    float cost = -1.0f;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t size = parts[i].last - parts[i].first;
      if (size <= kLeafSize) continue;
      const float c = half_area(parts[i].bounds) * leaves_for(size);
      if (chosen == parts.size() || c > cost) {
        cost = c;
        chosen = i;
      }
    }
    if (chosen == parts.size()) break;
    const Range r = parts[chosen];
    const std::uint32_t middle = split(r);
    parts[chosen] = range(r.first, middle, r.depth + 1);
    parts[count++] = range(middle, r.last, r.depth + 1);
  }
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({});
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t child = build(parts[i], triangles);
    Node& node = nodes_[self];
    node.child[i] = child;
    for (std::size_t k = 0; k < 3; ++k) {
      node.low[k][i] = parts[i].bounds.low[k];
      node.high[k][i] = parts[i].bounds.high[k];
    }
  }
  nodes_[self].children = static_cast<std::uint32_t>(count);
  return self;
}

std::uint32_t TriangleTree::add_leaf(const Range& whole, const std::vector<Triangle>& triangles) {
  Leaf leaf{};
  leaf.first = whole.first;
  leaf.count = whole.last - whole.first;
  for (std::uint32_t lane = 0; lane < leaf.count; ++lane) {
    const Triangle& t = triangles[order_[whole.first + lane]];
    const Vector3 centre =
        0.5 * t[0].cwiseMin(t[1]).cwiseMin(t[2]) + 0.5 * t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    double reach = 0.0, longest = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      reach = std::max(reach, (t[i] - centre).norm());
      longest = std::max(longest, (t[(i + 1) % 3] - t[i]).squaredNorm());
    }
    const Vector3 face = (t[1] - t[0]).cross(t[2] - t[0]);
    const double area = face.norm();
    // A plane of floats is good for triangles that are no needles; the others are told by their ball alone.
    constexpr double kNeedle = 1e-3;
    const Vector3 n = area > kNeedle * longest ? Vector3(face / area) : Vector3(Vector3::Zero());
    // The plane through the box's centre is off the triangle's; a corner tells by how much.
    const Vector3 foot = centre + n * n.dot(t[0] - centre);
    reach = std::max({(t[0] - foot).norm(), (t[1] - foot).norm(), (t[2] - foot).norm()});
    for (std::size_t k = 0; k < 3; ++k) {
      leaf.centre[k][lane] = static_cast<float>(foot[static_cast<Eigen::Index>(k)]);
      leaf.normal[k][lane] = static_cast<float>(n[static_cast<Eigen::Index>(k)]);
    }
    leaf.reach[lane] = rounded_up(reach);
  }
  leaves_.push_back(leaf);
  return static_cast<std::uint32_t>(leaves_.size() - 1) | kLeaf;
}

}  // namespace palpate::physics
