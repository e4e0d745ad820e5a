// Sections that stand as values, for the template sections.html.
#include <array>

#include "palpate/evaluation/report/page.h"

namespace palpate::evaluation::report {
namespace {

const char* name_of(figures::Tone tone) {
  constexpr std::array kNames{"ours", "rival", "third", "fourth", "muted", "good", "bad"};
  return kNames[static_cast<std::size_t>(tone)];
}

const char* name_of(figures::Mark mark) {
  constexpr std::array kNames{"line", "points", "steps", "bars", "area"};
  return kNames[static_cast<std::size_t>(mark)];
}

Json json_of(const figures::Figure& figure) {
  Json verdict;
  if (figure.verdict != figures::Verdict::none)
    verdict = figure.verdict == figures::Verdict::holds ? "holds" : "falls short";
  return {{"label", figure.label}, {"value", figure.value}, {"note", figure.bar}, {"verdict", verdict}};
}

Json json_of(const figures::Series& s) {
  return {{"name", s.name},
          {"mark", name_of(s.mark)},
          {"tone", name_of(s.tone)},
          {"quiet", !s.in_legend},
          {"dashed", s.dashed},
          {"filled", s.filled},
          {"x", s.labels.empty() ? Json(s.x) : Json(s.labels)},
          {"y", s.y},
          {"hover", s.hover},
          {"written", s.written}};
}

Json range_of(const std::array<double, 2>& range) { return range[0] == range[1] ? Json() : Json(range); }

Json json_of(const figures::Plot& plot) {
  Json series = Json::array(), levels = Json::array();
  for (const auto& s : plot.series) {
    series.push_back(json_of(s));
    series.back()["categories"] = !s.labels.empty();
    series.back()["logx"] = plot.log_x;
    series.back()["logy"] = plot.log_y;
  }
  for (const auto& level : plot.levels)
    levels.push_back({{"at", level.at},
                      {"to", level.to.value_or(level.at)},
                      {"label", level.label},
                      {"tone", name_of(level.tone)},
                      {"upright", level.upright}});
  return {{"title", plot.title},
          {"x", plot.x_label},
          {"y", plot.y_label},
          {"equal", plot.equal_axes},
          {"logx", plot.log_x},
          {"logy", plot.log_y},
          {"zero", plot.from_zero},
          {"stacked", plot.stacked},
          {"sideways", plot.sideways},
          {"flipx", plot.flip_x},
          {"flipy", plot.flip_y},
          {"xrange", range_of(plot.x_range)},
          {"yrange", range_of(plot.y_range)},
          {"height", plot.height_px},
          {"caption", plot.caption},
          {"series", series},
          {"levels", levels}};
}

// A block has all keys: a template looks further out for one that is missing.
struct Block {
  Json of(const char* key, Json value) const {
    Json block{{"text", nullptr}, {"cards", nullptr}, {"plots", nullptr}, {"table", nullptr}};
    block[key] = std::move(value);
    return block;
  }
  Json operator()(const std::string& text) const { return of("text", text); }
  Json operator()(const std::vector<figures::Figure>& figures) const {
    return of("cards", {{"figures", report::json_of(figures)}});
  }
  Json operator()(const std::vector<figures::Plot>& plots) const {
    Json row = Json::array();
    for (const auto& plot : plots) row.push_back(json_of(plot));
    return of("plots", {{"row", row}});
  }
  Json operator()(const figures::Table& table) const {
    return of("table", {{"header", table.header}, {"rows", table.rows}});
  }
};

}  // namespace

Json json_of(const std::vector<figures::Figure>& figures) {
  Json list = Json::array();
  for (const auto& figure : figures) list.push_back(json_of(figure));
  return list;
}

Json json_of(const std::vector<figures::Section>& sections) {
  Json list = Json::array();
  for (const auto& section : sections) {
    Json blocks = Json::array();
    for (const auto& block : section.blocks) blocks.push_back(std::visit(Block{}, block));
    list.push_back({{"title", section.title}, {"anchor", section.anchor}, {"blocks", blocks}});
  }
  return list;
}

}  // namespace palpate::evaluation::report
