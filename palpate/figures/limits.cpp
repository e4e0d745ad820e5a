#include "palpate/figures/limits.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "palpate/core/toml.h"

namespace palpate::figures {
namespace {

std::optional<double> number_in(const Json& figures, std::string_view path) {
  const Json* value = find_in(figures, path);
  return value != nullptr && value->is_number() ? std::optional(value->get<double>()) : std::nullopt;
}

struct Limit {
  double at = 0.0;
  bool at_most = true;
};

// Every key is read, whatever the figures are: a mistake in the file shows at once.
std::optional<Limit> limit_in(const TomlTable& table, const Json& figures) {
  if (table.has("at_least")) return Limit{table.number("at_least"), false};
  double most = table.number_or("at_most", std::numeric_limits<double>::infinity());
  const auto others = table.texts("least_of");
  const double share = table.number_or("share", 1.0);
  double least = std::numeric_limits<double>::infinity();
  for (const auto& path : others) least = std::min(least, number_in(figures, path).value_or(least));
  if (!others.empty() && !std::isfinite(least)) return std::nullopt;
  most = std::min(most, share * least);
  if (!std::isfinite(most)) return std::nullopt;
  return Limit{most, true};
}

Json judge(const TomlTable& table, const Json& figures) {
  const std::string figure = table.text("figure"), label = table.text_or("label", figure),
                    unit = table.text_or("unit", ""), of = table.text_or("of", ""),
                    needed_by = table.text_or("needed_by", "");
  const double of_at_least = table.number_or("of_at_least", 0.0);
  const auto limit = limit_in(table, figures);
  Json result{{"figure", figure}, {"label", label},   {"unit", unit},
              {"value", nullptr}, {"limit", nullptr}, {"verdict", nullptr}};
  if (limit) result["limit"] = limit->at, result["bound"] = limit->at_most ? "at most" : "at least";
  const auto value = number_in(figures, figure), whole = of.empty() ? 1.0 : number_in(figures, of);
  if (!value || !whole) {
    if (needed_by.empty() || find_in(figures, needed_by) == nullptr) return nullptr;
    result["verdict"] = "falls short";
    return result;
  }
  result["value"] = of.empty() ? *value : *value / *whole;
  if (!limit || (!of.empty() && *whole < of_at_least)) return result;
  const double bar = limit->at * *whole;
  result["verdict"] = (limit->at_most ? *value <= bar : *value >= bar) ? "holds" : "falls short";
  return result;
}

}  // namespace

const Json* find_in(const Json& figures, std::string_view path) {
  const Json* at = &figures;
  while (!path.empty()) {
    const auto slash = path.find('/');
    const std::string key(path.substr(0, slash));
    if (!at->is_object() || !at->contains(key)) return nullptr;
    at = &(*at)[key];
    path = slash == std::string_view::npos ? "" : path.substr(slash + 1);
  }
  return at;
}

Expected<Json> judged(const Json& figures, std::string_view limits_toml, std::string source) {
  const auto file = parse_toml(limits_toml, std::move(source));
  if (!file) return tl::unexpected(file.error());
  Json all = Json::object();
  for (const auto& name : file->keys())
    if (Json one = judge(file->table(name), figures); !one.is_null()) all[name] = std::move(one);
  if (const auto done = file->finish(); !done) return tl::unexpected(done.error());
  return all;
}

}  // namespace palpate::figures
