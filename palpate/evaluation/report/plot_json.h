// Plots and clouds as the JSON that page.js draws; numbers are rounded to what an eye can see, which keeps
// pages small.
#pragma once

#include <string>
#include <vector>

#include "palpate/figures/plot.h"

namespace palpate::evaluation::report {

std::string plot_json(const figures::Plot& plot);
std::string cloud_json(const figures::Cloud& cloud);

// A JSON array: each number to a ten-thousandth of their span, or to four digits of its own where `relative`
// (for logarithmic axes); not a number as null.
std::string json_numbers(const std::vector<double>& values, bool relative = false);

}  // namespace palpate::evaluation::report
