// Figures over many numbers. Pure functions, and a summary that one thread keeps.
#pragma once

#include <cstddef>
#include <vector>

namespace palpate::inline core {

// The upper one of the two middle values where there are two; 0 for none. Takes the vector apart.
double median(std::vector<double> values);

// The q-quantile (0..1), linear between neighbours; what is not finite is left out. Not a number for none.
double quantile(std::vector<double> values, double q);

// Of many errors: rms, mean, maximum, quantiles. They are kept, all of them.
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
