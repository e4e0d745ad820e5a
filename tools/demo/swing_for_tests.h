// For tests: an application that no program has, a weight on a string. It needs no surface, keeps a table and a count
// of its passes through the middle, and has a part in the page.
#pragma once

#include <cmath>
#include <memory>

#include "palpate/core/csv.h"
#include "palpate/scene/application_registry.h"

namespace palpate::tools::demo {

class Swing : public scene::Application {
 public:
  void step(Instant<PhysicsClock> now, Duration, const scene::TipState& tip,
            scene::SceneState& state) override {
    const double t = now.seconds(), x = 0.1 * std::sin(6.0 * t);
    if (x * before_ < 0.0) ++passes_;
    before_ = x;
    state.body_count = 2;
    state.bodies[0].set_p({x, -1.3, 1.3});
    state.bodies[scene::kCarried].set_p(tip.X_world_tip.translation);
    state.bodies[scene::kCarried].set_q(tip.X_world_tip.rotation);
    state.counters[0] = passes_;
  }
  const scene::ImpactEvent& impact() const override { return none_; }

 private:
  void begin() override {}
  void reset() override { passes_ = 0; }
  double before_ = 0.0;
  std::int32_t passes_ = 0;
  scene::ImpactEvent none_;
};

class SwingView : public scene::SceneView {
 public:
  std::vector<scene::DrawItem> draw(const scene::SceneState&) const override { return {}; }
  std::vector<std::string> captions(const scene::SceneState&) const override { return {}; }
};

class SwingRecord : public scene::PlayRecord {
 public:
  void add_state(const scene::SceneState& state) override { passes_ = state.counters[0]; }
  void add_picture(const scene::SceneState& shown) override {
    table_.row(std::vector<double>{shown.time.seconds(), shown.bodies[0].p().x()});
  }
  scene::Highlight highlight(const scene::ShownPicture& picture) const override {
    return {.in_sight = picture.have_state && picture.shows(picture.state.bodies[0].p()),
            .events = picture.state.counters[0],
            .event = "pass",
            .just_after = "the weight has just passed",
            .going_on = "the weight swings",
            .unseen = "the weight swings elsewhere"};
  }
  std::vector<std::string> tables() const override { return {table_.content()}; }
  Json summary() const override { return {{"swing", {{"passes", passes_}}}}; }
  std::vector<scene::ClosingLine> closing_lines(const Json& summary) const override {
    return {{"swing", fmt::format("{} passes", summary["swing"]["passes"].get<int>())}};
  }

 private:
  CsvWriter table_{{"time_s", "x_m"}};
  std::int32_t passes_ = 0;
};

inline scene::ApplicationSpec swing_for_tests() {
  scene::ApplicationSpec spec;
  spec.name = "swing";
  spec.summary = "A weight on a string";
  spec.make_physics = [](const auto&...) { return std::make_unique<Swing>(); };
  spec.make_view = [](const auto&...) { return std::make_unique<SwingView>(); };
  spec.tables = {{"swing.csv", "the weight, picture by picture"}};
  spec.make_record = [](const auto&...) { return std::make_unique<SwingRecord>(); };
  spec.report = [](const figures::PlayFolder& play) {
    scene::PlayReport report{.title = "A swing",
                             .task = "watch a weight",
                             .scene = "The weight is not there.",
                             .drawn = "a weight",
                             .figures = {},
                             .sections = {}};
    report.figures = {{"Passes", figures::shown(play.number("swing/passes"), ""), "at most 3",
                       figures::at_most(play.number("swing/passes").value_or(0.0), 3.0)}};
    report.sections = {{"How it swung", "swing", {"To and fro.", report.figures}}};
    return report;
  };
  return spec;
}

inline scene::ApplicationRegistry registry_for_tests() {
  scene::ApplicationRegistry registry;
  registry.add(swing_for_tests());
  return registry;
}

}  // namespace palpate::tools::demo
