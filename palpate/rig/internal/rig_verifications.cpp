#include "palpate/rig/internal/rig_verifications.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <ctime>

namespace palpate::rig {
namespace {

constexpr std::array kOtherKeys = {"date", "form", "holds", "changed"};

bool is_figure(const std::string& key) {
  for (const char* other : kOtherKeys)
    if (key == other) return false;
  return true;
}

}  // namespace

std::vector<VerificationRecord> verifications_of(const TomlTable& file) {
  std::vector<VerificationRecord> records;
  for (const auto& table : file.tables("verification")) {
    VerificationRecord record;
    record.date = table.text("date");
    std::tm when{};
    if (table.has("date") &&
        (record.date.size() != 20 || ::strptime(record.date.c_str(), "%Y-%m-%dT%H:%M:%SZ", &when) == nullptr))
      table.complain(
          "date", fmt::format("is '{}', a UTC time such as 2026-01-31T12:00:00Z is expected", record.date));
    record.form = table.choice("form", {"full", "quick"});
    record.holds = table.flag("holds");
    record.changed = table.texts("changed");
    for (const auto& key : table.keys()) {
      if (!is_figure(key)) continue;
      const auto n = table.numbers<6>(key);
      record.figures.push_back({key, n[0], n[1], n[2], n[3], n[4], n[5]});
    }
    records.push_back(std::move(record));
  }
  return records;
}

std::string verifications_text(const std::vector<VerificationRecord>& records) {
  std::string text;
  const std::size_t first = records.size() > kVerificationsKept ? records.size() - kVerificationsKept : 0;
  for (std::size_t i = first; i < records.size(); ++i) {
    const auto& record = records[i];
    text += "\n[[verification]]\n";
    if (i == first)
      text +=
          "# Figures: the rig's own error, its 95 % interval (low, high), what was promised to bound it; "
          "the\n"
          "# differences observed, and what these were to stay below.\n";
    text += fmt::format("date = {}\nform = {}\nholds = {}\nchanged = [", toml_quoted(record.date),
                        toml_quoted(record.form), record.holds);
    for (std::size_t k = 0; k < record.changed.size(); ++k)
      text += (k > 0 ? ", " : "") + toml_quoted(record.changed[k]);
    text += "]\n";
    for (const auto& figure : record.figures)
      text += fmt::format("{} = [{}, {}, {}, {}, {}, {}]\n", figure.name, toml_number(figure.error),
                          toml_number(figure.low), toml_number(figure.high), toml_number(figure.promised),
                          toml_number(figure.seen), toml_number(figure.seen_most));
  }
  return text;
}

}  // namespace palpate::rig
