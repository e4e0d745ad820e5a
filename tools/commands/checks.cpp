#include "tools/commands/checks.h"

#include <fmt/format.h>

#include <utility>

#include "palpate/core/nearest.h"
#include "palpate/core/text.h"

namespace palpate::tools::commands {
namespace {

template <typename Fits>
CLI::Validator number(const std::string& expected, Fits fits) {
  return {[expected, fits](std::string& text) -> std::string {
            double value = 0.0;
            // NaN fits nowhere.
            if (CLI::detail::lexical_cast(text, value) && fits(value)) return "";
            return fmt::format("'{}'; {} is expected", excerpt(text), expected);
          },
          expected};
}

}  // namespace

CLI::Validator between(double low, double high) {
  return number(fmt::format("{} to {}", low, high), [low, high](double v) { return v >= low && v <= high; });
}
CLI::Validator at_least_zero() {
  return number("0 or more", [](double v) { return v >= 0.0; });
}
CLI::Validator above_zero() {
  return number("more than 0", [](double v) { return v > 0.0; });
}

CLI::Validator one_of(std::vector<std::string> words) {
  const std::string all = CLI::detail::join(words, ", ");
  return {[words = std::move(words), all](std::string& text) -> std::string {
            for (const auto& word : words)
              if (text == word) return "";
            const auto meant = nearest(text, words);
            return fmt::format("'{}'; one of {} is expected{}", excerpt(text), all,
                               meant.empty() ? "" : fmt::format("; did you mean {}?", meant));
          },
          all};
}

Expected<void> refuse_given(const CLI::App& command, std::initializer_list<const char*> options,
                            std::string_view words) {
  for (const char* option : options)
    if (command.count(option) > 0) return wrong_use("{}: {}", option, words);
  return {};
}

}  // namespace palpate::tools::commands
