// What is kept of a play with the jelly: each press, for summary.json, the report and raw/jelly.csv.
#pragma once

#include <vector>

#include "palpate/scene/application_registry.h"

namespace jelly {

inline constexpr const char* kTable = "jelly.csv";

class JellyRecord : public palpate::scene::PlayRecord {
 public:
  void add_state(const palpate::scene::SceneState& state) override;
  palpate::scene::Highlight highlight(const palpate::scene::ShownPicture& picture) const override;
  std::vector<std::string> tables() const override;
  palpate::Json summary() const override;
  std::vector<palpate::scene::ClosingLine> closing_lines(const palpate::Json& summary) const override;

 private:
  struct Row {
    double time, force, dent;  // s, N, m
  };
  std::vector<Row> rows_;
  std::int32_t presses_ = 0;
  double peak_ = 0.0, deepest_ = 0.0;
};

palpate::scene::PlayReport report_of(const palpate::figures::PlayFolder& play);

}  // namespace jelly
