#include "palpate/experiment/conditions.h"

#include <algorithm>
#include <array>
#include <set>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/toml.h"
#include "palpate/experiment/trial_columns.h"

namespace palpate::experiment {
namespace {

constexpr std::size_t kLongestWord = 60, kLongestQuestion = 200;
constexpr std::array<std::string_view, 3> kTasks{"choice", "comparison", "yes-no"};
constexpr std::array<std::string_view, 2> kMethods{"constant-stimuli", "staircase"};
constexpr std::string_view kTwoDownOneUp = "two-down-one-up", kUpDown = "up-down", kWeighted = "weighted";

bool is_identifier(std::string_view word) {
  return !word.empty() && word.size() <= kLongestWord && std::all_of(word.begin(), word.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

// What stands in a cell of a table as it is.
bool is_level(std::string_view word) {
  return !word.empty() && word.size() <= kLongestWord && is_plain(word) &&
         word.find_first_of(",\"#") == word.npos && word.front() != ' ' && word.back() != ' ';
}

template <std::size_t N>
std::size_t choice_of(const TomlTable& table, std::string_view key,
                      const std::array<std::string_view, N>& names) {
  const auto said = table.choice(key, {names.begin(), names.end()});
  const auto at = std::find(names.begin(), names.end(), said);
  return at == names.end() ? 0 : static_cast<std::size_t>(at - names.begin());
}

std::string identifier(const TomlTable& table, std::string_view key) {
  auto word = table.text(key);
  if (!is_identifier(word))
    table.complain(key, fmt::format("is \"{}\"; 1 to {} letters, digits, - and _ are expected", excerpt(word),
                                    kLongestWord));
  return word;
}

int whole(const TomlTable& table, std::string_view key, int fallback, int low, int high) {
  return static_cast<int>(
      table.integer_or(key, fallback, {static_cast<double>(low), static_cast<double>(high)}));
}

void read_constant(const TomlTable& table, Conditions& conditions) {
  if (!table.exists())
    table.complain("levels", "is missing, the stimuli of method \"constant-stimuli\" are expected");
  conditions.levels = table.numbers("levels", 0, kPositive);
  conditions.repeats = static_cast<int>(table.integer("repeats", {1.0, kMostTrials}));
  std::vector<double> sorted = conditions.levels;
  std::sort(sorted.begin(), sorted.end());
  if (sorted.size() < 2 || sorted.size() > 1000)
    table.complain("levels",
                   fmt::format("has {}, 2 to 1000 are expected", counted(sorted.size(), "stimulus")));
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    table.complain("levels",
                   "names a stimulus twice; each once is expected, `repeats` says how often it comes");
}

void read_staircase(const TomlTable& table, Conditions& conditions) {
  auto& rule = conditions.rule;
  const auto said =
      table.choice("rule", {std::string(kTwoDownOneUp), std::string(kUpDown), std::string(kWeighted)});
  rule.kind = said == kWeighted ? StaircaseKind::weighted : StaircaseKind::transformed;
  if (rule.kind == StaircaseKind::weighted) rule.target = table.number("target", {0.05, 0.95});
  rule.down_after = said == kUpDown ? whole(table, "down_after", 1, 1, 10) : 2;
  rule.lowest = table.number("lowest", kPositive);
  rule.highest = table.number("highest", kPositive);
  rule.start = table.number("start", kPositive);
  rule.step_factors = table.numbers("step_factors", 0, kPositive);
  rule.reversals = whole(table, "reversals", rule.reversals, 2, 1000);
  rule.discard = whole(table, "discard", rule.discard, 0, 1000);
  rule.most_trials = whole(table, "most_trials", rule.most_trials, 2, kMostTrials);
  conditions.tracks = whole(table, "tracks", 1, 1, 100);
  if (const auto wrong = complaint_of(rule)) table.complain(wrong->key, wrong->message);
}

Factor read_factor(const TomlTable& table) {
  Factor factor{identifier(table, "name"), {}};
  table.expect("levels");
  table.expect("choices");
  if (table.has("levels") == table.has("choices")) {
    table.complain("levels", "either levels = [numbers] or choices = [\"words\"] is expected");
    return factor;
  }
  if (table.has("choices")) factor.levels = table.texts("choices");
  if (table.has("levels"))
    for (const double level : table.numbers("levels", 0)) factor.levels.push_back(number_text(level));
  const std::string_view key = table.has("choices") ? "choices" : "levels";
  for (const auto& level : factor.levels)
    if (!is_level(level))
      table.complain(key,
                     fmt::format("holds \"{}\"; 1 to {} characters without comma, quote and # are expected",
                                 excerpt(level), kLongestWord));
  if (factor.levels.empty()) table.complain(key, "is empty, one level or more is expected");
  if (std::set<std::string>(factor.levels.begin(), factor.levels.end()).size() != factor.levels.size())
    table.complain(key, "names a level twice; each once is expected");
  return factor;
}

void read_factors(const TomlTable& root, Conditions& conditions) {
  std::set<std::string> names;
  std::size_t cells = 1;
  for (const auto& table : root.tables("factor")) {
    auto factor = read_factor(table);
    if (!names.insert(factor.name).second) table.complain("name", "is the name of another factor, too");
    if (is_trial_column(factor.name))
      table.complain("name", fmt::format("\"{}\" is a column of the file of trials; use another name",
                                         excerpt(factor.name)));
    cells = std::min(cells * std::max<std::size_t>(factor.levels.size(), 1), kMostCells + 1);
    conditions.factors.push_back(std::move(factor));
  }
  if (cells > kMostCells)
    root.complain("factor",
                  fmt::format("the factors have more than {} combinations; fewer are expected", kMostCells));
}

void read_task(const TomlTable& root, Conditions& conditions) {
  conditions.task = static_cast<TaskKind>(choice_of(root, "task", kTasks));
  conditions.places = conditions.task == TaskKind::yes_no ? 1 : 2;
  if (conditions.task == TaskKind::choice) conditions.places = whole(root, "places", 2, 2, 20);
  if (conditions.task == TaskKind::comparison && whole(root, "places", 2, 1, 20) != 2)
    root.complain("places", "a comparison is of 2");
}

// What no single key shows.
void check_together(const TomlTable& root, const Conditions& conditions) {
  if (conditions.method == Method::staircase) {
    const double guess = shape_of(conditions).guess, sought = share_sought(conditions.rule);
    if (conditions.task == TaskKind::choice && sought <= guess + 0.05)
      root.table("staircase")
          .complain(
              conditions.rule.kind == StaircaseKind::weighted ? "target" : "rule",
              fmt::format("closes in on {:.3g} right, of which guessing alone gives {:.3g}; more is expected",
                          sought, guess));
  }
  if (most_trials(conditions) > kMostTrials)
    root.complain(
        "method",
        fmt::format("there would be more than {} trials; use fewer repeats, levels or factors", kMostTrials));
}

std::string list_of(const std::vector<double>& numbers) {
  std::string all;
  for (const double x : numbers) all += (all.empty() ? "" : ", ") + toml_number(x);
  return "[" + all + "]";
}

std::string staircase_text(const Conditions& conditions) {
  const auto& rule = conditions.rule;
  std::string text = "\n[staircase]\n";
  if (rule.kind == StaircaseKind::weighted)
    text += fmt::format(
        "rule = \"{}\"  # or \"{}\", \"{}\"\ntarget = {}  # share of positive answers that it closes in on\n",
        kWeighted, kTwoDownOneUp, kUpDown, toml_number(rule.target));
  else if (rule.down_after == 2)
    text += fmt::format("rule = \"{}\"  # closes in on 70.7 %; or \"{}\", \"{}\"\n", kTwoDownOneUp, kWeighted,
                        kUpDown);
  else
    text += fmt::format("rule = \"{}\"\ndown_after = {}  # positive answers in a row\n", kUpDown,
                        rule.down_after);
  text += fmt::format("start = {}\nlowest = {}\nhighest = {}\n", toml_number(rule.start),
                      toml_number(rule.lowest), toml_number(rule.highest));
  text += fmt::format(
      "step_factors = {}  # downwards, up to the first reversal, the second, ...; the last one stays\n",
      list_of(rule.step_factors));
  text += fmt::format(
      "reversals = {}  # it ends with so many, or with most_trials\ndiscard = {}  # of them not "
      "used\nmost_trials = {}\n",
      rule.reversals, rule.discard, rule.most_trials);
  return text + fmt::format("tracks = {}  # staircases of each combination of factors, interleaved\n",
                            conditions.tracks);
}

}  // namespace

TaskShape shape_of(const Conditions& conditions) {
  TaskShape shape;
  if (conditions.task == TaskKind::comparison) shape.rule = GuessRule::equals_lapse;
  shape.guess = conditions.task == TaskKind::choice ? 1.0 / conditions.places : 0.0;
  return shape;
}

std::vector<std::vector<std::string>> cells_of(const Conditions& conditions) {
  std::vector<std::vector<std::string>> cells{{}};
  for (const auto& factor : conditions.factors) {
    std::vector<std::vector<std::string>> longer;
    for (const auto& cell : cells)
      for (const auto& level : factor.levels) {
        longer.push_back(cell);
        longer.back().push_back(level);
      }
    cells = std::move(longer);
  }
  return cells;
}

int most_trials(const Conditions& conditions) {
  const auto each = conditions.method == Method::constant_stimuli
                        ? conditions.levels.size() * static_cast<std::size_t>(conditions.repeats)
                        : static_cast<std::size_t>(conditions.tracks) *
                              static_cast<std::size_t>(conditions.rule.most_trials);
  std::size_t trials = each;
  for (const auto& factor : conditions.factors) trials *= factor.levels.size();
  return static_cast<int>(std::min<std::size_t>(trials, kMostTrials + 1));
}

Expected<Conditions> parse_conditions(std::string_view content, std::string source) {
  const auto root = parse_toml(content, std::move(source));
  if (!root) return tl::unexpected(root.error());
  Conditions conditions;
  conditions.name = identifier(*root, "name");
  conditions.question = root->text_or("question", "");
  if (conditions.question.size() > kLongestQuestion || !is_plain(conditions.question))
    root->complain("question", fmt::format("a line of at most {} bytes is expected", kLongestQuestion));
  read_task(*root, conditions);
  conditions.stimulus = identifier(*root, "stimulus");
  conditions.method = static_cast<Method>(choice_of(*root, "method", kMethods));
  conditions.practice = whole(*root, "practice", 0, 0, 1000);
  conditions.rest_after = whole(*root, "rest_after", 0, 0, kMostTrials);
  conditions.repeat_excluded = root->flag_or("repeat_excluded", false);
  if (conditions.method == Method::constant_stimuli)
    read_constant(root->table("constant"), conditions);
  else
    read_staircase(root->table("staircase"), conditions);
  read_factors(*root, conditions);
  if (const auto done = root->finish(); !done) return tl::unexpected(done.error());
  check_together(*root, conditions);
  if (const auto done = root->finish(); !done) return tl::unexpected(done.error());
  return conditions;
}

Expected<Conditions> read_conditions(const std::filesystem::path& path) {
  const auto content = read_file(path, kMostSettingsBytes);
  if (!content) return tl::unexpected(content.error());
  return parse_conditions(*content, path.string());
}

std::string conditions_text(const Conditions& conditions) {
  std::string text =
      "# Conditions of an experiment. Every combination of the factors is tried with every stimulus.\n";
  text += fmt::format("name = {}\nquestion = {}\n", toml_quoted(conditions.name),
                      toml_quoted(conditions.question));
  text += fmt::format(
      "task = \"{}\"  # \"choice\": where is it; \"comparison\": which of two is larger; \"yes-no\": is it "
      "there\n",
      kTasks[static_cast<std::size_t>(conditions.task)]);
  if (conditions.task == TaskKind::choice)
    text += fmt::format("places = {}  # guessing is right once in so many\n", conditions.places);
  text += fmt::format("stimulus = {}  # what is varied, with its unit; above 0\n",
                      toml_quoted(conditions.stimulus));
  text += fmt::format("method = \"{}\"  # or \"{}\", which has a section of its own\n",
                      kMethods[static_cast<std::size_t>(conditions.method)],
                      kMethods[1 - static_cast<std::size_t>(conditions.method)]);
  text += fmt::format(
      "practice = {}  # trials before the first that counts\nrest_after = {}  # trials between rests, 0 for "
      "none\nrepeat_excluded = {}  # trials that were left out come again at the end\n",
      conditions.practice, conditions.rest_after, conditions.repeat_excluded);
  if (conditions.method == Method::constant_stimuli)
    text += fmt::format(
        "\n[constant]\nlevels = {}\nrepeats = {}  # of each level in each combination of factors\n",
        list_of(conditions.levels), conditions.repeats);
  else
    text += staircase_text(conditions);
  for (const auto& factor : conditions.factors) {
    text += fmt::format("\n[[factor]]\nname = {}\nchoices = [", toml_quoted(factor.name));
    for (std::size_t i = 0; i < factor.levels.size(); ++i)
      text += (i > 0 ? ", " : "") + toml_quoted(factor.levels[i]);
    text += "]  # or levels = [numbers]\n";
  }
  return text;
}

Conditions example_conditions(Method method) {
  Conditions conditions;
  conditions.name = "stiffness";
  conditions.question = "Which of the two is stiffer?";
  conditions.method = method;
  conditions.stimulus = "stiffness_ratio";
  conditions.practice = 8;
  conditions.rest_after = 50;
  conditions.repeat_excluded = true;
  if (method == Method::constant_stimuli) {
    conditions.task = TaskKind::comparison;
    conditions.levels = {0.61, 0.75, 0.85, 0.92, 1.08, 1.18, 1.33, 1.65};
    conditions.repeats = 10;
  } else {
    conditions.task = TaskKind::choice;
    conditions.rule.lowest = 1.01;
    conditions.rule.step_factors = {1.2, 1.1, 1.05};
    conditions.tracks = 2;
  }
  conditions.factors = {{"sight", {"with", "without"}}};
  return conditions;
}

std::string hash_of(const Conditions& conditions) { return content_hash(conditions_text(conditions)); }

}  // namespace palpate::experiment
