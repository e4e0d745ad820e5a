// An application's part of a demo's report. Made from what the play left in its folder, so that a report can be made
// again at any time. Values.
//
// Its words may stand here, or in files that the application has in ApplicationSpec::page (docs/guides/new-application.md);
// then what is left to compute goes to `data`.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/figures/section.h"

namespace palpate::scene {

struct PlayReport {
  std::string title;  // of the page: "Palpate: ping-pong you can see and feel"
  std::string task;   // what is done in a play, after "calibrate everything,": "play ping-pong"
  std::string scene;  // what is real here and what is not, and what the hand feels; whole sentences
  std::string drawn;  // what is drawn into the camera's picture: "ball and racket"
  std::string force_label = "Strongest force the hand felt";
  std::vector<figures::Figure> figures{};    // among the page's first
  std::vector<figures::Section> sections{};  // after those on the calibration and the exchange
  Json data = Json::object();                // numbers that the application's templates name, as "data."
};

}  // namespace palpate::scene
