// A tree of boxes over triangles: which of them a sphere on a straight path may touch, the nearest ones
// first.
//
// Four children to a node, four triangles to a leaf, tested together. Built by the surface area heuristic in
// bins (Goldsmith and Salmon 1987; Wald 2007), so that the tree is good also where triangles are of unlike
// size. Boxes are floats, grown by more than all rounding: the tree may name a triangle too many, never one
// too few; what touches is decided in double by triangle.h. Any unit of length. Const, safe from any thread,
// no allocation after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "palpate/physics/float4.h"
#include "palpate/physics/triangle.h"

namespace palpate::physics {

class TriangleTree {
 public:
  TriangleTree() = default;
  // Puts `triangles` into the order of the leaves; order()[i] is the place triangle i had before.
  explicit TriangleTree(std::vector<Triangle>& triangles);

  const std::vector<std::uint32_t>& order() const { return order_; }

  // Calls test(i) for every triangle that a sphere of `radius` going from `from` to `to` may touch up to the
  // fraction `best`, a variable that test() lowers when it finds a touch. May call it for others.
  template <typename Test>
  void visit(const Vector3& from, const Vector3& to, double radius, const double& best, Test&& test) const;

 private:
  static constexpr std::uint32_t kLeaf = 0x80000000u;  // marks a child that is a leaf
  struct alignas(64) Node {
    std::array<Float4, 3> low, high;  // of the four children
    std::array<std::uint32_t, 4> child;
    std::uint32_t children = 0;
  };
  struct alignas(64) Leaf {
    std::array<Float4, 3> centre, normal;  // of the box and of the face; a thin triangle has normal 0
    Float4 reach;                          // farthest corner from the centre
    std::uint32_t first = 0, count = 0;    // triangles [first, first + count)
  };
  struct Bounds {
    std::array<float, 3> low, high;
  };
  struct Range {
    std::uint32_t first, last;
    int depth;
    Bounds bounds;
  };
  class Path;  // of the sphere, in floats
  struct Waiting {
    std::uint32_t child;
    float enter, apart2;
    // What is met first comes first; of boxes in which the path begins, the one nearest to its middle.
    bool after(const Waiting& o) const { return enter > o.enter || (enter == o.enter && apart2 > o.apart2); }
  };
  static constexpr int kDeepest = 40;  // from there on halves: 32 levels more at most
  static constexpr std::size_t kStack = 3 * (kDeepest + 32) + 4;

  Range range(std::uint32_t first, std::uint32_t last, int depth) const;
  std::uint32_t split(const Range& whole);  // the place between the two halves
  std::uint32_t build(const Range& whole, const std::vector<Triangle>& triangles);
  std::uint32_t add_leaf(const Range& whole, const std::vector<Triangle>& triangles);

  std::vector<Bounds> bounds_;  // of each triangle, while building
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::uint32_t root_ = 0;
  double extent_ = 0.0;  // largest coordinate
};

class TriangleTree::Path {
 public:
  Path(const Vector3& from, const Vector3& to, double radius, double extent) {
    const Vector3 d = to - from;
    const double scale =
        extent + from.cwiseAbs().maxCoeff() + to.cwiseAbs().maxCoeff() + radius;  // bounds every number here
    // Each float is off by 6e-8 of that at most, and no result is made of more than eight of them.
    const double pad = 1e-6 * scale;
    for (std::size_t i = 0; i < 3; ++i) {
      const double along = d[static_cast<Eigen::Index>(i)];
      from_[i] = four(static_cast<float>(from[static_cast<Eigen::Index>(i)]));
      d_[i] = four(static_cast<float>(along));
      // A motion below the padding is none.
      over_d_[i] = four(std::abs(along) > pad ? static_cast<float>(1.0 / along) : 1e30f);
    }
    reach_ = four(static_cast<float>(radius + 2.0 * pad));
    const double dd = d.squaredNorm();
    over_dd_ = four(dd > 0.0 ? static_cast<float>(1.0 / dd) : 0.0f);
    half_length_ = 0.5f * static_cast<float>(std::sqrt(dd));
    end_at(1.0);
  }

  void end_at(double best) {
    const auto s = static_cast<float>(best * (1.0 + 1e-6));
    best_ = four(s);
    for (std::size_t i = 0; i < 3; ++i) {
      middle_[i] = from_[i] + four(0.5f * s) * d_[i];
      end_[i] = from_[i] + best_ * d_[i];
    }
    const Float4 r = reach_ + four(s * half_length_);
    ball2_ = r * r;
  }
  float best() const { return best_[0]; }

  // Which of four boxes the sphere may touch, when it enters them grown by its radius, and their squared
  // distance from the middle of its path.
  unsigned boxes(const Node& node, Float4& enter, Float4& apart2) const {
    enter = apart2 = four(0.0f);
    Float4 exit = best_;
    for (std::size_t i = 0; i < 3; ++i) {
      const Float4 a = (node.low[i] - from_[i] - reach_) * over_d_[i];
      const Float4 b = (node.high[i] - from_[i] + reach_) * over_d_[i];
      enter = upper(enter, lower(a, b));
      exit = lower(exit, upper(a, b));
      const Float4 apart = upper(upper(node.low[i] - middle_[i], middle_[i] - node.high[i]), four(0.0f));
      apart2 += apart * apart;
    }
    return bits((enter <= exit) & (apart2 <= ball2_)) & ((1u << node.children) - 1u);
  }

  // Which of four triangles it may touch: by the plane of each, and by a ball around each.
  unsigned triangles(const Leaf& leaf) const {
    Float4 h0 = four(0.0f), h1 = four(0.0f), along = four(0.0f);
    std::array<Float4, 3> to_centre;
    for (std::size_t i = 0; i < 3; ++i) {
      to_centre[i] = leaf.centre[i] - from_[i];
      h0 -= leaf.normal[i] * to_centre[i];
      h1 -= leaf.normal[i] * (leaf.centre[i] - end_[i]);
      along += to_centre[i] * d_[i];
    }
    const Float4 s = lower(upper(along * over_dd_, four(0.0f)), best_);
    Float4 apart2 = four(0.0f);
    for (std::size_t i = 0; i < 3; ++i) {
      const Float4 apart = to_centre[i] - s * d_[i];
      apart2 += apart * apart;
    }
    const Float4 r = reach_ + leaf.reach;
    const Mask4 slab = (lower(h0, h1) <= reach_) & (upper(h0, h1) >= -reach_);
    return bits(slab & (apart2 <= r * r)) & ((1u << leaf.count) - 1u);
  }

 private:
  std::array<Float4, 3> from_, d_, over_d_, middle_, end_;
  Float4 reach_, over_dd_, best_, ball2_;
  float half_length_ = 0.0f;
};

template <typename Test>
void TriangleTree::visit(const Vector3& from, const Vector3& to, double radius, const double& best,
                         Test&& test) const {
  if (leaves_.empty()) return;
  Path path(from, to, radius, extent_);
  double known = 1.0;
  std::array<Waiting, kStack> stack;
  std::size_t depth = 0;
  stack[depth++] = {root_, 0.0f, 0.0f};
  while (depth > 0) {
    const Waiting next = stack[--depth];
    if (next.enter > path.best()) continue;
    if ((next.child & kLeaf) != 0) {
      const Leaf& leaf = leaves_[next.child & ~kLeaf];
      for (unsigned left = path.triangles(leaf); left != 0; left &= left - 1u) {
        test(leaf.first + static_cast<std::uint32_t>(__builtin_ctz(left)));
        if (best < known) path.end_at(known = best);
      }
      continue;
    }
    const Node& node = nodes_[next.child];
    Float4 enter, apart2;
    const std::size_t bottom = depth;
    for (unsigned left = path.boxes(node, enter, apart2); left != 0; left &= left - 1u) {
      const auto lane = static_cast<std::size_t>(__builtin_ctz(left));
      const Waiting child{node.child[lane], enter[lane], apart2[lane]};
      std::size_t at = depth++;  // the nearest on top
      for (; at > bottom && child.after(stack[at - 1]); --at) stack[at] = stack[at - 1];
      stack[at] = child;
    }
  }
}

}  // namespace palpate::physics
