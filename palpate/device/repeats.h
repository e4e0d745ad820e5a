// Measurements that repeat an earlier one to the last digit: a tracker polled faster than it measures, rows
// pasted twice. They tell nothing new, yet would make every stated deviation smaller; they count once.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "palpate/core/text.h"

namespace palpate::device {

// The numbers of one measurement, to compare it with others by.
class Reading {
 public:
  Reading& add(double number) {
    numbers_.push_back(number);
    return *this;
  }
  Reading& add(const Eigen::Ref<const Eigen::VectorXd>& numbers) {
    for (const double number : numbers) add(number);
    return *this;
  }
  // Whether it is there, then what it holds.
  template <typename T>
  Reading& add_if(const std::optional<T>& numbers) {
    add(numbers ? 1.0 : 0.0);
    return numbers ? add(*numbers) : *this;
  }
  auto operator<=>(const Reading&) const = default;

 private:
  std::vector<double> numbers_;
};

// Removes the items whose reading, by `reading_of(item)`, an earlier item has; the others keep their order.
// Returns how many were removed.
template <typename Item, typename ReadingOf>
std::size_t drop_repeats(std::vector<Item>& items, const ReadingOf& reading_of) {
  std::set<Reading> known;
  return std::erase_if(items, [&](const Item& item) { return !known.insert(reading_of(item)).second; });
}

// For a person: "3 rows repeat ..." .
inline std::string repeats_warning(std::size_t count) {
  return counted(count, "row") + (count == 1 ? " repeats an earlier one" : " repeat earlier ones") +
         " to the last digit; each measurement counts once";
}

}  // namespace palpate::device
