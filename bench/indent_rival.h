// A block on a rigid table pressed by a sphere, in Bullet's deformable body: bench/indent.
#pragma once

#include <memory>

#include "palpate/math/so3.h"

namespace palpate::bench {

struct RivalBlock {
  Vector3 size{0.12, 0.12, 0.05};  // m
  double young = 6000.0;           // Pa
  double poisson = 0.45;
  double radius = 0.005;  // m
  int across = 10;        // cells along each side; five tetrahedra each
  int up = 6;
  bool between_nodes = false;  // the sphere comes down in the middle of a cell, not on a node
};

struct RivalPress {
  double depth = 0.0;                               // m
  double force = 0.0, lowest = 0.0, highest = 0.0;  // N on the table, over the last third of the time held
  int inside = 0;                                   // nodes of the body inside the sphere at the end
};

// Presses deeper and deeper, at 20 mm/s, and holds each depth for 0.3 s.
class Rival {
 public:
  virtual ~Rival() = default;
  virtual RivalPress press_to(double depth) = 0;
  virtual int nodes() const = 0;
  virtual double ms_per_step() const = 0;  // median, of 1/240 s
};

// Null where Bullet is not installed.
std::unique_ptr<Rival> make_bullet_block(const RivalBlock& block);

}  // namespace palpate::bench
