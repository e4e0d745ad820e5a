// A trial of an experiment, what was answered, and why a trial may not count. Values, any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace palpate::experiment {

struct Trial {
  int number = 0;  // from 1, in the order of presentation
  bool practice = false;
  int block = 0;         // of constant stimuli, from 1; 0 in practice and of staircases
  int track = 0;         // of staircases, from 1; 0 in practice and of constant stimuli
  int repeated = 0;      // how often it was left out before
  std::size_t cell = 0;  // of cells_of(conditions)
  double stimulus = 0.0;
  int target = 1;  // the place, from 1, that has the stimulus; the other ones have the standard

  bool operator==(const Trial&) const = default;
};

// Why a trial is left out: what was felt is not what the conditions say.
enum class Exclusion : std::uint8_t { none, force_limited, tripped, interrupted };
inline constexpr std::array<std::string_view, 4> kExclusionNames{"", "force-limited", "tripped",
                                                                 "interrupted"};
inline std::string_view name_of(Exclusion exclusion) {
  return kExclusionNames[static_cast<std::size_t>(exclusion)];
}

struct Answer {
  int place = 0;            // from 1; of a yes-no task 1 is yes and 2 no; 0: none, of a trial left out alone
  double response_s = 0.0;  // how long it took
  double time_s = 0.0;      // when it came, since the run's beginning
  Exclusion exclusion = Exclusion::none;
};

struct TrialRecord {
  Trial trial;
  Answer answer;
  bool positive = false;

  bool counts() const { return !trial.practice && answer.exclusion == Exclusion::none; }
};

}  // namespace palpate::experiment
