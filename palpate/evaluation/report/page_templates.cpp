#include "palpate/evaluation/report/page_templates.h"

#include <algorithm>
#include <deque>
#include <iterator>
#include <kainjow/mustache.hpp>
#include <unordered_map>

#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/evaluation/report/format.h"

namespace palpate::evaluation::report {
namespace {

using Data = kainjow::mustache::data;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const auto first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return "";
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

// Walks "a.b.c" down from `from`; null where there is no such thing.
const Json* walk(const Json* from, std::string_view path) {
  while (from != nullptr && !path.empty()) {
    const auto dot = path.find('.');
    const std::string key(path.substr(0, dot));
    from = from->is_object() && from->contains(key) ? &(*from)[key] : nullptr;
    path = dot == std::string_view::npos ? "" : path.substr(dot + 1);
  }
  return from;
}

// The names in {{KIND name}} for any of these kinds, such as "#^".
std::vector<std::string> names_of(std::string_view text, std::string_view kinds) {
  std::vector<std::string> names;
  for (auto at = text.find("{{"); at != std::string_view::npos; at = text.find("{{", at)) {
    at += 2;
    const auto end = text.find('}', at);
    if (end == std::string_view::npos) break;
    if (kinds.find(text[at]) == std::string_view::npos) continue;
    names.emplace_back(trimmed(text.substr(at + 1, end - at - 1)));
    at = end;
  }
  return names;
}

// A template with all that it takes in, by file. Each is checked to be there, to be whole, and not to take itself in.
class TemplateFiles {
 public:
  explicit TemplateFiles(const PageTemplates& templates) : templates_(templates) {}

  Expected<void> add(const std::string& file) {
    if (std::find(open_.begin(), open_.end(), file) != open_.end())
      return wrong_use("{} takes itself in", file);
    if (texts_.contains(file)) return {};
    if (!templates_.has(file) && open_.empty()) return wrong_use("{}: there is no such template", file);
    if (!templates_.has(file))
      return wrong_use("{} names the template {}, which is not there", open_.back(), excerpt(file));
    const std::string_view text = templates_.text(file);
    const kainjow::mustache::mustache whole{std::string(text)};
    if (!whole.is_valid()) return wrong_use("{}: {}", file, excerpt(whole.error_message()));
    texts_[file] = text;
    open_.push_back(file);
    for (const auto& part : names_of(text, ">"))
      if (auto done = add(part + ".html"); !done) return done;
    open_.pop_back();
    return {};
  }

  // The names of {{#...}} and {{^...}}: they may be absent.
  std::set<std::string> conditions() const {
    std::set<std::string> names;
    for (const auto& [file, text] : texts_)
      for (auto& name : names_of(text, "#^")) names.insert(std::move(name));
    return names;
  }

  // The file in which {{name}} stands; the first where it stands in several, `otherwise` where in none.
  std::string with_value(std::string_view name, const std::string& otherwise) const {
    for (const auto& [file, text] : texts_)
      for (auto at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
        const auto before = text.find_last_not_of(' ', at == 0 ? 0 : at - 1);
        if (at > 0 && before != std::string_view::npos && text[before] == '{') return file;
      }
    return otherwise;
  }

 private:
  const PageTemplates& templates_;
  std::map<std::string, std::string_view> texts_;
  std::vector<std::string> open_;  // that took in the one being added, from the first
};

// What the library asks for names, answered from JSON.
class JsonContext : public kainjow::mustache::basic_context<std::string> {
 public:
  JsonContext(const PageTemplates& templates, const std::vector<const Json*>& data,
              const std::filesystem::path& folder)
      : templates_(templates), stack_(data), folder_(folder) {}

  void push(const Data* data) override {
    const auto found = json_of_.find(data);
    stack_.push_back(found == json_of_.end() ? nullptr : found->second);
  }
  void pop() override { stack_.pop_back(); }

  const Data* get(const std::string& name) const override {
    const auto bar = name.find('|');
    const std::string_view path = trimmed(std::string_view(name).substr(0, bar));
    const Json* value = find(path);
    (value == nullptr ? absent_ : found_).insert(name);
    if (value == nullptr) return nullptr;
    if (bar == std::string::npos) return made(*value);
    const auto format = trimmed(std::string_view(name).substr(bar + 1));
    const std::string text = formatted(*value, format, folder_);
    return &made_.emplace_back(text.empty() ? Data(false) : Data(text));
  }

  const Data* get_partial(const std::string& name) const override {
    return &made_.emplace_back(std::string(templates_.text(name + ".html")));
  }

  const std::set<std::string>& found() const { return found_; }
  const std::set<std::string>& absent() const { return absent_; }

 private:
  const Json* find(std::string_view path) const {
    if (path == ".") return stack_.back();
    for (auto at = stack_.rbegin(); at != stack_.rend(); ++at)
      if (const Json* value = walk(*at, path); value != nullptr) return value;
    return nullptr;
  }

  // As the library sees it: a list, a text, or false; an object stands for itself, and is asked for through us.
  const Data* made(const Json& json) const {
    if (const auto known = data_of_.find(&json); known != data_of_.end()) return known->second;
    Data& data = made_.emplace_back(shape_of(json));
    if (json.is_array())
      for (std::size_t i = 0; i < json.size(); ++i) json_of_[&data.list_value()[i]] = &json[i];
    json_of_[&data] = &json;
    data_of_[&json] = &data;
    return &data;
  }
  static Data shape_of(const Json& json) {
    if (json.is_null() || json == false || json == "") return Data(false);
    if (json.is_object()) return Data(Data::type::object);
    if (!json.is_array()) return Data(formatted(json, ""));
    Data list(Data::type::list);
    for (const auto& item : json) list.push_back(shape_of(item));
    return list;
  }

  const PageTemplates& templates_;
  std::vector<const Json*> stack_;
  const std::filesystem::path& folder_;
  mutable std::deque<Data> made_;
  mutable std::unordered_map<const Data*, const Json*> json_of_;
  mutable std::unordered_map<const Json*, const Data*> data_of_;
  mutable std::set<std::string> found_, absent_;  // names that were asked for
};

}  // namespace

PageTemplates::PageTemplates() { add(report_files()); }

void PageTemplates::add(const figures::PageFiles& files) {
  for (const auto& file : files) files_[std::string(file.name)] = std::string(file.text);
}

void PageTemplates::add_missing(const figures::PageFiles& files) {
  for (const auto& file : files) files_.emplace(file.name, file.text);
}

void PageTemplates::use(const std::string& file, const std::string& in_place_of) {
  if (const auto found = files_.find(file); found != files_.end()) files_[in_place_of] = found->second;
}

Expected<void> PageTemplates::add_folder(const std::filesystem::path& folder) {
  std::error_code none;
  if (!std::filesystem::is_directory(folder, none))
    return wrong_use("{}: a folder of templates is expected, as share/palpate/report", folder.string());
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    auto text = read_file(entry.path());
    if (!text) return tl::unexpected(text.error());
    files_[entry.path().filename().string()] = std::move(*text);
  }
  return {};
}

bool PageTemplates::has(std::string_view name) const { return files_.find(name) != files_.end(); }

std::string_view PageTemplates::text(std::string_view name) const {
  const auto found = files_.find(name);
  return found == files_.end() ? std::string_view() : std::string_view(found->second);
}

Expected<Rendered> PageTemplates::render(std::string_view name, const std::vector<const Json*>& data,
                                         const std::filesystem::path& folder) const {
  const std::string file = fmt::format("{}.html", name);
  TemplateFiles files(*this);
  if (const auto done = files.add(file); !done) return tl::unexpected(done.error());
  JsonContext context(*this, data, folder);
  Rendered rendered{kainjow::mustache::mustache(std::string(text(file))).render(context), {}};
  const auto conditions = files.conditions();
  for (const auto& absent : context.absent())
    if (!conditions.contains(absent))
      return wrong_use("{} names '{}', which the report does not hold", files.with_value(absent, file),
                       excerpt(absent));
  std::set_intersection(context.found().begin(), context.found().end(), conditions.begin(), conditions.end(),
                        std::inserter(rendered.found, rendered.found.end()));
  return rendered;
}

}  // namespace palpate::evaluation::report
