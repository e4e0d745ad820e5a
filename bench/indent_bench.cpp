// A soft block pressed by a spherical tip: the full solution, the law of the haptic tick, and Bullet's deformable body, in the same run.
//
// Block 120 x 120 x 50 mm of 6 kPa, Poisson's ratio 0.45, bonded to the table; tip of 5 mm; depths of 1 to 5 mm. Errors beside the full
// neo-Hookean solution, which docs/theory/deformable.md holds against an independent solver. Bullet comes down on a node of its mesh and between
// nodes, on two meshes; its force is the table's, the mean while the depth is held, with the lowest and the highest in brackets.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <vector>

#include "bench/indent_rival.h"
#include "palpate/physics/deformable/half_space.h"
#include "palpate/physics/deformable/indentation.h"
#include "palpate/physics/deformable/quick_indentation.h"

namespace palpate {
namespace {

namespace deformable = physics::deformable;
using Clock = std::chrono::steady_clock;

const std::vector<double> kDepths = {0.001, 0.003, 0.005};

double since_s(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

void print_row(const std::string& name, const std::vector<std::string>& cells, const std::string& cost) {
  fmt::print("{:<40}", name);
  for (const auto& cell : cells) fmt::print(" {:>24}", cell);
  fmt::print("   {}\n", cost);
  std::fflush(stdout);  // a row may take a minute
}

std::string beside(double force, double full) {
  return fmt::format("{:.4f} N ({:+.1f} %)", force, 100.0 * (force / full - 1.0));
}

void press_rival(const bench::RivalBlock& block, const std::vector<deformable::IndentationPoint>& full) {
  const auto rival = bench::make_bullet_block(block);
  if (!rival) return print_row("Bullet's deformable body", {"not installed (libbullet-dev)"}, "");
  std::vector<std::string> cells;
  int inside = 0;
  for (std::size_t i = 0; i < kDepths.size(); ++i) {
    const auto press = rival->press_to(kDepths[i]);
    cells.push_back(fmt::format("{:.2f} x ({:.2f}, {:.2f})", press.force / full[i].force,
                                press.lowest / full[i].force, press.highest / full[i].force));
    inside = std::max(inside, press.inside);
  }
  print_row(fmt::format("Bullet, {} nodes, {}", rival->nodes(),
                        block.between_nodes ? "between nodes" : "on a node"),
            cells,
            fmt::format("{:.1f} ms a step of 1/240 s, at most {} nodes inside the tip", rival->ms_per_step(),
                        inside));
}

int run() {
  deformable::Indentation block;
  block.material.matrix = {6000.0, 0.45};
  block.size = {0.12, 0.12, 0.05};
  block.radius = 0.005;
  block.depths = kDepths;
  std::vector<std::string> heads;
  for (const double depth : kDepths) heads.push_back(fmt::format("{:.0f} mm deep", 1e3 * depth));
  print_row("", heads, "cost");

  auto begins = Clock::now();
  const auto full = deformable::solve_indentation(block);
  if (!full) return fmt::print(stderr, "full: {}\n", full.error().message), 1;
  std::vector<std::string> cells;
  for (const auto& point : *full) cells.push_back(fmt::format("{:.4f} N", point.force));
  print_row("full solution, neo-Hookean", cells, fmt::format("{:.1f} s for all", since_s(begins)));

  cells.clear();
  for (std::size_t i = 0; i < kDepths.size(); ++i)
    cells.push_back(
        beside(deformable::hertz_force(block.material.matrix, block.radius, kDepths[i]) *
                   deformable::bonded_layer_factor(0.45, block.radius, kDepths[i], block.size.z()),
               (*full)[i].force));
  print_row("Hertz, bonded layer (Dimitriadis 2002)", cells, "closed form, for small depths");

  begins = Clock::now();
  const auto law = deformable::site_law_of_block(block);
  if (!law) return fmt::print(stderr, "tick: {}\n", law.error().message), 1;
  const double prepared_s = since_s(begins);
  cells.clear();
  for (std::size_t i = 0; i < kDepths.size(); ++i)
    cells.push_back(beside(law->force(kDepths[i]), (*full)[i].force));
  constexpr int kTimes = 20'000;
  begins = Clock::now();
  double sum = 0.0;
  for (int i = 0; i < kTimes; ++i) sum += law->force(1e-3 + 4e-3 * i / kTimes);
  const double each_us = 1e6 * since_s(begins) / kTimes;
  print_row("law of the haptic tick", cells,
            fmt::format("{:.2f} us in closed form, prepared in {:.1f} s{}", each_us, prepared_s,
                        sum > 0.0 ? "" : "?"));

  for (const auto& [across, up] : {std::pair{10, 6}, std::pair{18, 11}})
    for (const bool between : {false, true}) {
      bench::RivalBlock rival;
      rival.across = across, rival.up = up, rival.between_nodes = between;
      press_rival(rival, *full);
    }
  return 0;
}

}  // namespace
}  // namespace palpate

int main() { return palpate::run(); }
