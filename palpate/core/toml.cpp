#include "palpate/core/toml.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "palpate/core/file.h"
#include "palpate/core/file_form.h"
#include "palpate/core/internal/toml_check.h"
#include "palpate/core/nearest.h"
#include "palpate/core/text.h"

namespace palpate::inline core {
namespace {
constexpr std::size_t kLongestMessage = 480;  // bytes
}

struct TomlTable::Document {
  std::string source;
  toml::table root;
  std::set<const toml::node*> used;
  std::map<const toml::table*, std::set<std::string, std::less<>>> asked;  // keys each table was asked for
  std::optional<Error> error;                                              // the first complaint
  std::optional<std::pair<const toml::table*, std::string>> missing;       // what it missed, if that was it

  void complain(int line, const std::string& message) {
    if (error) return;
    const auto shown = excerpt(message, kLongestMessage);  // keys and texts of the file are in it
    error = Error{Error::Kind::wrong_use, line > 0 ? fmt::format("{}:{}: {}", source, line, shown)
                                                   : fmt::format("{}: {}", source, shown)};
  }
};

namespace {

const toml::node& as_node(const void* node) { return *static_cast<const toml::node*>(node); }

int line_of(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

std::string_view kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

// The complaint about an unknown key names the nearest known one, or all of them.
std::string remedy(std::string_view key, const std::set<std::string, std::less<>>& known) {
  if (const auto meant = nearest(key, known); !meant.empty()) return fmt::format("did you mean '{}'?", meant);
  std::string list;
  for (const auto& name : known) list += (list.empty() ? "" : ", ") + name;
  return known.empty() ? std::string("no keys are known here") : fmt::format("known here: {}", list);
}

}  // namespace

TomlTable::TomlTable(std::shared_ptr<Document> document, const void* table, std::string path)
    : document_(std::move(document)), table_(table), path_(std::move(path)) {}

namespace {
const toml::table* as_table(const void* table) { return static_cast<const toml::table*>(table); }
}  // namespace

bool TomlTable::exists() const { return table_ != nullptr; }

bool TomlTable::has(std::string_view key) const { return table_ && as_table(table_)->contains(key); }

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  if (table_)
    for (const auto& [key, node] : *as_table(table_)) names.emplace_back(key.str());
  return names;
}

int TomlTable::line() const { return table_ ? line_of(*as_table(table_)) : 0; }

void TomlTable::expect(std::string_view key) const {
  if (!table_) return;
  document_->asked[as_table(table_)].emplace(key);
  if (const auto* node = as_table(table_)->get(key)) document_->used.insert(node);
}

void TomlTable::complain(std::string_view key, std::string_view message) const {
  const auto* node = table_ ? as_table(table_)->get(key) : nullptr;
  document_->complain(node ? line_of(*node) : line(), fmt::format("{}{}: {}", path_, key, message));
}

const void* TomlTable::wanted(std::string_view key, std::string_view kind, bool required) const {
  expect(key);
  const toml::node* node = table_ ? as_table(table_)->get(key) : nullptr;
  if (!node && required) {
    if (table_ && !document_->error) document_->missing.emplace(as_table(table_), key);
    complain(key, fmt::format("is missing, {} is expected", kind));
  }
  return node;
}

double TomlTable::number_of(const void* node, std::string_view key, NumberRange range) const {
  const auto value = as_node(node).is_number() ? as_node(node).value<double>() : std::nullopt;
  const int at = line_of(as_node(node));
  if (!value) {
    document_->complain(at,
                        fmt::format("{}{}: is {}, a number is expected", path_, key, kind_of(as_node(node))));
  } else if (!std::isfinite(*value)) {
    document_->complain(at, fmt::format("{}{}: is {}, a finite number is expected", path_, key, *value));
  } else if (*value < range.low || *value > range.high) {
    std::string expectation;
    if (range.high == kPositive.high && range.low == kPositive.low) {
      expectation = "a number above 0";
    } else if (range.high == kPositive.high) {
      expectation = fmt::format("at least {}", range.low);
    } else if (range.low == kAnyNumber.low) {
      expectation = fmt::format("at most {}", range.high);
    } else {
      expectation = fmt::format("{} to {}", range.low, range.high);
    }
    document_->complain(at, fmt::format("{}{}: is {}, {} is expected", path_, key, *value, expectation));
  } else {
    return *value;
  }
  return std::isfinite(range.low) && range.low > kAnyNumber.low ? range.low : 0.0;
}

double TomlTable::number(std::string_view key, NumberRange range) const {
  const void* node = wanted(key, "a number", true);
  return node ? number_of(node, key, range) : std::max(range.low, std::min(0.0, range.high));
}

double TomlTable::number_or(std::string_view key, double fallback, NumberRange range) const {
  const void* node = wanted(key, "a number", false);
  return node ? number_of(node, key, range) : fallback;
}

long long TomlTable::integer(std::string_view key, NumberRange range) const {
  if (!wanted(key, "a whole number", true)) return 0;
  return integer_or(key, 0, range);
}

long long TomlTable::integer_or(std::string_view key, long long fallback, NumberRange range) const {
  const void* node = wanted(key, "a whole number", false);
  if (!node) return fallback;
  if (!as_node(node).is_integer()) {
    complain(key, fmt::format("is {}, a whole number is expected", kind_of(as_node(node))));
    return fallback;
  }
  number_of(node, key, range);
  return as_node(node).value<std::int64_t>().value_or(fallback);
}

bool TomlTable::flag(std::string_view key) const {
  return wanted(key, "true or false", true) ? flag_or(key, false) : false;
}

bool TomlTable::flag_or(std::string_view key, bool fallback) const {
  const void* node = wanted(key, "true or false", false);
  if (!node) return fallback;
  if (!as_node(node).is_boolean()) {
    complain(key, fmt::format("is {}, true or false is expected", kind_of(as_node(node))));
    return fallback;
  }
  return as_node(node).value<bool>().value_or(fallback);
}

std::string TomlTable::text(std::string_view key) const {
  return wanted(key, "a text", true) ? text_or(key, "") : std::string();
}

std::string TomlTable::text_or(std::string_view key, std::string fallback) const {
  const void* node = wanted(key, "a text", false);
  if (!node) return fallback;
  if (!as_node(node).is_string()) {
    complain(key, fmt::format("is {}, a text in quotes is expected", kind_of(as_node(node))));
    return fallback;
  }
  return as_node(node).value<std::string>().value_or(fallback);
}

std::vector<std::string> TomlTable::texts(std::string_view key) const {
  std::vector<std::string> result;
  const void* node = wanted(key, "a list of texts", false);
  if (!node) return result;
  const auto* array = as_node(node).as_array();
  if (!array) complain(key, fmt::format("is {}, a list of texts is expected", kind_of(as_node(node))));
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    const auto value = (*array)[i].value<std::string>();
    if (!value) {
      complain(key, fmt::format("holds {}, a list of texts is expected", kind_of((*array)[i])));
      break;
    }
    result.push_back(*value);
  }
  return result;
}

std::string TomlTable::choice(std::string_view key, const std::vector<std::string>& allowed) const {
  const auto value = text(key);
  if (std::find(allowed.begin(), allowed.end(), value) == allowed.end()) {
    std::string list;
    for (const auto& name : allowed) list += (list.empty() ? "\"" : ", \"") + name + "\"";
    complain(key, fmt::format("is \"{}\", one of {} is expected", excerpt(value), list));
  }
  return value;
}

// The toml::array; null where there is none of so many entries (0: of any number), which is complained of.
const void* TomlTable::wanted_list(std::string_view key, std::size_t count, std::string_view expected) const {
  const void* node = wanted(key, expected, true);
  if (node == nullptr) return nullptr;
  const toml::array* list = as_node(node).as_array();
  if (list == nullptr)
    complain(key, fmt::format("is {}, {} is expected", kind_of(as_node(node)), expected));
  else if (count > 0 && list->size() != count)
    complain(key, fmt::format("has {} entries, {} is expected", list->size(), expected));
  else
    return list;
  return nullptr;
}

std::vector<double> TomlTable::numbers(std::string_view key, std::size_t count, NumberRange range) const {
  std::vector<double> result;
  const std::string expected = count > 0 ? fmt::format("a list of {} numbers", count) : "a list of numbers";
  if (const auto* list = static_cast<const toml::array*>(wanted_list(key, count, expected)))
    for (std::size_t i = 0; i < list->size(); ++i) result.push_back(number_of(list->get(i), key, range));
  if (count > 0) result.resize(count, std::max(range.low, std::min(0.0, range.high)));
  return result;
}

std::vector<std::vector<double>> TomlTable::rows(std::string_view key, std::size_t width, std::size_t count,
                                                 NumberRange range) const {
  std::vector<std::vector<double>> result;
  const std::string expected = count > 0 ? fmt::format("a list of {} lists of {} numbers", count, width)
                                         : fmt::format("a list of lists of {} numbers", width);
  if (const auto* list = static_cast<const toml::array*>(wanted_list(key, count, expected)))
    for (std::size_t i = 0; i < list->size(); ++i) {
      const auto* inner = list->get(i)->as_array();
      if (!inner || inner->size() != width) {
        complain(key, fmt::format("entry {} is not a list of {} numbers", i + 1, width));
        break;
      }
      auto& row = result.emplace_back();
      for (std::size_t j = 0; j < width; ++j) row.push_back(number_of(inner->get(j), key, range));
    }
  if (count > 0) result.resize(count, std::vector<double>(width, 0.0));
  return result;
}

TomlTable TomlTable::table(std::string_view key) const {
  const std::string path = fmt::format("{}{}.", path_, key);
  const void* node = wanted(key, "a table", false);
  if (!node) return {document_, nullptr, path};
  const auto* inner = as_node(node).as_table();
  if (!inner) complain(key, fmt::format("is {}, a table is expected", kind_of(as_node(node))));
  return {document_, inner, path};
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  std::vector<TomlTable> result;
  const void* node = wanted(key, "a list of tables", false);
  if (!node) return result;
  const auto* array = as_node(node).as_array();
  if (!array)
    complain(key, fmt::format("is {}, a list of tables [[{}]] is expected", kind_of(as_node(node)), key));
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    const auto* inner = (*array)[i].as_table();
    if (!inner) {
      complain(key, fmt::format("holds {}, a list of tables [[{}]] is expected", kind_of((*array)[i]), key));
      break;
    }
    result.push_back({document_, inner, fmt::format("{}{}[{}].", path_, key, i + 1)});
  }
  return result;
}

namespace {

struct Unknown {
  int line = 0;
  std::string message;
};

// The unused key on the lowest line; descends only into what was asked for.
void find_unused(const toml::table& table, const std::string& path, const std::set<const toml::node*>& used,
                 const std::map<const toml::table*, std::set<std::string, std::less<>>>& asked,
                 std::optional<Unknown>& first) {
  for (const auto& [key, node] : table) {
    if (!used.contains(&node)) {
      const int line = static_cast<int>(key.source().begin.line);
      if (first && first->line <= line) continue;
      const auto known = asked.find(&table);
      first = Unknown{line, fmt::format("unknown key '{}{}'; {}", path, excerpt(key.str()),
                                        remedy(key.str(), known == asked.end() ? decltype(known->second){}
                                                                               : known->second))};
    } else if (const auto* inner = node.as_table(); inner && asked.contains(inner)) {
      find_unused(*inner, fmt::format("{}{}.", path, key.str()), used, asked, first);
    } else if (const auto* array = node.as_array()) {
      for (std::size_t i = 0; i < array->size(); ++i)
        if (const auto* entry = (*array)[i].as_table(); entry && asked.contains(entry))
          find_unused(*entry, fmt::format("{}{}[{}].", path, key.str(), i + 1), used, asked, first);
    }
  }
}

}  // namespace

Expected<void> TomlTable::finish() const {
  if (!document_->error) {
    std::optional<Unknown> first;
    find_unused(document_->root, "", document_->used, document_->asked, first);
    if (first) document_->complain(first->line, first->message);
  } else if (const auto missing = std::exchange(document_->missing, std::nullopt)) {
    // Now that everything has been asked for, a key that nobody knows may be the missing one, misspelt.
    std::vector<std::string> unknown;
    for (const auto& [key, node] : *missing->first)
      if (!document_->used.contains(&node)) unknown.emplace_back(key.str());
    if (const auto written = nearest(missing->second, unknown); !written.empty())
      document_->error->message += fmt::format("; '{}' is an unknown key, was it meant?", excerpt(written));
  }
  if (document_->error) return tl::unexpected(*document_->error);
  return {};
}

Expected<TomlTable> parse_toml(std::string_view content, std::string source) {
  if (const auto fine = check_toml(content, source); !fine) return tl::unexpected(fine.error());
  auto document = std::make_shared<TomlTable::Document>();
  document->source = std::move(source);
  try {
    document->root = toml::parse(content, document->source);
  } catch (const toml::parse_error& error) {
    if (const auto form = form_of(content); form != FileForm::unknown && !is_toml(form))
      return wrong_use("{}: {}; a TOML file is expected", document->source, words_of(form));
    return wrong_use("{}:{}: is not valid TOML ({}); repair the line", document->source,
                     error.source().begin.line, excerpt(error.description(), kLongestMessage));
  }
  const toml::table* root = &document->root;
  document->asked[root];
  return TomlTable(document, root, "");
}

Expected<TomlTable> read_toml(const std::filesystem::path& path) {
  const auto content = read_file(path, kMostSettingsBytes);
  if (!content) return tl::unexpected(content.error());
  return parse_toml(*content, path.string());
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);  // shortest form that reads back the same
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_quoted(std::string_view text) {
  std::string result = "\"";
  while (!text.empty()) {
    const Character c = first_character(text);
    if (c.code == '"' || c.code == '\\') {
      result += '\\';
      result += text.front();
    } else if (!c.valid) {
      result += "\uFFFD";  // bytes that are no UTF-8: nothing could read the file again
    } else if (is_control(c.code)) {
      const auto code = static_cast<std::uint32_t>(c.code);
      result += code < 0x10000 ? fmt::format("\\u{:04x}", code) : fmt::format("\\U{:08x}", code);
    } else {
      result += text.substr(0, c.bytes);
    }
    text.remove_prefix(c.bytes);
  }
  return result + "\"";
}

}  // namespace palpate::inline core
