// Figures over many errors: rms, mean, maximum, quantiles. They are kept, all of them. One thread.
#pragma once

#include <cstddef>
#include <vector>

namespace palpate::inline core {

class ErrorSummary {
 public:
  void add(double error) { errors_.push_back(error); }
  bool empty() const { return errors_.empty(); }
  std::size_t count() const { return errors_.size(); }
  double rms() const;
  double mean() const;
  double maximum() const;
  // Smallest error not exceeded by the given share (nearest rank); 0 for none.
  double quantile(double share) const;

 private:
  std::vector<double> errors_;
};

}  // namespace palpate::inline core
