// What an experiment is: the question, the stimuli, what else is varied, how often, in which order. A TOML file.
//
// Every combination of the factors' levels is a cell; within a cell the stimulus is varied, by the method of constant stimuli
// (each level so many times) or by staircases. The file is read strictly: a complaint names file, line and key. Stimuli are
// above 0, in the unit that the stimulus' name ends in. Values, any thread. Errors: wrong use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/experiment/psychometric.h"
#include "palpate/experiment/staircase.h"

namespace palpate::experiment {

enum class Method : std::uint8_t { constant_stimuli, staircase };

enum class TaskKind : std::uint8_t {
  choice,  // where is it? Positive: the place was right. Guessing is right once in `places`.
  comparison,  // which of two is larger? Positive: the one with the stimulus, the other being the standard, was taken.
  yes_no,  // is it there? Positive: yes.
};

struct Factor {
  std::string name;                 // a column of the file of trials
  std::vector<std::string> levels;  // as written there; numbers in the form of number_text()
};

struct Conditions {
  std::string name = "experiment";  // of letters, digits, - and _
  std::string question;
  TaskKind task = TaskKind::choice;
  int places = 2;  // what there is to choose from; 1 for yes_no
  std::string stimulus = "stimulus";
  Method method = Method::constant_stimuli;
  int practice = 0;              // trials before the first that counts
  int rest_after = 0;            // trials between rests; 0: none
  bool repeat_excluded = false;  // trials left out come again at the end, each up to kMostRepeats times
  std::vector<double> levels;    // of constant stimuli
  int repeats = 10;
  StaircaseRule rule;  // of staircases
  int tracks = 1;      // staircases a cell
  std::vector<Factor> factors;
};

inline constexpr int kMostRepeats = 3;
inline constexpr std::size_t kMostCells = 1000;
inline constexpr int kMostTrials = 100'000;

// What the task's answers are fitted with.
TaskShape shape_of(const Conditions& conditions);

// The combinations of the factors' levels, the last factor changing fastest; one without levels where there is no factor.
std::vector<std::vector<std::string>> cells_of(const Conditions& conditions);

// So many trials at most, without practice and repeats.
int most_trials(const Conditions& conditions);

Expected<Conditions> read_conditions(const std::filesystem::path& path);
Expected<Conditions> parse_conditions(std::string_view content, std::string source);

// A file that read_conditions() gives the same back from, with comments for whoever fills it in.
std::string conditions_text(const Conditions& conditions);
// To begin with: which of two is stiffer, with and without sight.
Conditions example_conditions(Method method);

// Of what is in the file, whatever its comments and spaces are.
std::string hash_of(const Conditions& conditions);

}  // namespace palpate::experiment
